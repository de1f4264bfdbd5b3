//! `fairform studio` as a browser meets it, and as others meet it.

use std::fs;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::process::{Child, Stdio};

use crate::common::Folder;

/// The studio while it runs; it ends with the test.
struct Studio {
    child: Child,
    host: String,
    token: String,
}

impl Studio {
    fn start(folder: &Folder, file: &str) -> Self {
        let mut child = folder
            .command("studio --no-open")
            .arg(file)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut url = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut url).unwrap();
        let (host, token) = url.trim().strip_prefix("http://").unwrap().split_once('/').unwrap();
        let token = token.trim_end_matches('/').into();
        Self { child, host: host.into(), token }
    }

    /// Status, header and body of the answer to a GET.
    fn get(&self, path: &str, more: &str) -> (u16, String, Vec<u8>) {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        let path = path.replace("TOKEN", &self.token);
        let more = match more.contains("Host:") {
            true => more.into(),
            false => format!("Host: {}\r\n{more}", self.host),
        };
        write!(stream, "GET {path} HTTP/1.1\r\n{more}Connection: close\r\n\r\n").unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        let end = answer.windows(4).position(|w| w == b"\r\n\r\n").unwrap();
        let head = String::from_utf8(answer[..end].to_vec()).unwrap();
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        (status, head.to_lowercase(), answer[end + 4..].to_vec())
    }
}

impl Drop for Studio {
    fn drop(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

/// Without the page, which needs more than Rust to be built, there is nothing to serve.
fn is_built() -> bool {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../studio/dist/index.html");
    fs::exists(page).unwrap()
}

#[test]
fn a_command_without_the_page_says_how_to_get_it() {
    let folder = Folder::new();
    if !is_built() {
        let run = folder.run("studio --no-open");
        assert_eq!(run.code, Some(1));
        assert!(run.stderr.contains("cargo xtask studio"), "{}", run.stderr);
    }
}

#[test]
fn a_file_that_is_not_there_is_named_before_anything_starts() {
    let folder = Folder::new();
    if is_built() {
        let run = folder.run("studio --no-open nothing.obj");
        assert_eq!(run.code, Some(1));
        assert!(run.stderr.contains("nothing.obj: cannot read it"), "{}", run.stderr);
    }
}

#[test]
fn the_page_and_the_file_are_served_to_whoever_knows_the_address() {
    if !is_built() {
        return;
    }
    let folder = Folder::new();
    folder.write("a b.obj", "v 0 0 0\n");
    let studio = Studio::start(&folder, "a b.obj");
    let (status, head, page) = studio.get("/TOKEN/", "");
    assert_eq!(status, 200);
    assert!(head.contains("content-security-policy: default-src 'none'"), "{head}");
    assert!(String::from_utf8(page).unwrap().contains("fairform-served"));
    let (status, head, file) = studio.get("/TOKEN/api/file", "");
    assert_eq!((status, file.as_slice()), (200, b"v 0 0 0\n".as_slice()));
    assert!(head.contains("x-file-name: a%20b.obj"), "{head}");

    assert_eq!(studio.get("/", "").0, 404);
    assert_eq!(studio.get("/0123456789abcdef0123456789abcdef/api/file", "").0, 404);
    assert_eq!(studio.get("/TOKEN/../Cargo.toml", "").0, 404);
    assert_eq!(studio.get("/TOKEN/api/file", "Host: example.org\r\n").0, 403);
    assert_eq!(studio.get("/TOKEN/api/file", "Origin: http://example.org\r\n").0, 403);
}
