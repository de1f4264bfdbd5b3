//! `fairform studio`: the modeller in the browser, served to this machine alone.

use std::fs;
use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use axum::Router;
use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, HOST, ORIGIN, REFERRER_POLICY,
    X_CONTENT_TYPE_OPTIONS,
};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode};
use axum::response::{IntoResponse, Response};
use serde_json::json;

use crate::args;
use crate::console::Console;
use crate::failure::Failure;
use crate::input;

/// The page as it was built, see `cargo xtask studio`.
#[derive(rust_embed::Embed)]
#[folder = "../../studio/dist"]
struct Page;

/// What the page may do: its own scripts and the kernel, and no word to any other host.
const POLICY: &str = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self' 'unsafe-inline'; \
     img-src 'self' blob: data:; font-src 'self'; connect-src 'self' blob: data:; worker-src 'self' blob:; \
     manifest-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Tells the page that there is a file to ask for.
const SERVED: &str = r#"<meta name="fairform-served" content="yes">"#;

pub(crate) fn run(args: &args::Studio, console: &Console) -> Result<ExitCode, Failure> {
    if Page::get("index.html").is_none() {
        return Err(Failure::new("this fairform was built without the page of the studio").help(
            "in a clone of fairform, `cargo xtask studio` builds the page and opens it; needs Node.js",
        ));
    }
    let file = args.input.as_deref().map(checked).transpose()?;
    let listener = std::net::TcpListener::bind((Ipv4Addr::LOCALHOST, args.port))
        .map_err(|e| no_port(args.port, &e))?;
    let address = listener.local_addr().map_err(|e| no_port(args.port, &e))?;
    let desk = Arc::new(Desk::new(address, token()?, file));
    let url = desk.url();
    console.result(&json!({ "url": url }))?;
    if !console.json() {
        console.print(&format!("{url}\n"))?;
    }
    console.note("the studio is at this address until Ctrl-C");
    if !args.no_open && webbrowser::open(&url).is_err() {
        console.note("no browser could be started: open the address in one");
    }
    serve(listener, desk).map_err(|e| Failure::new(format!("the studio's server stopped: {e}")))?;
    Ok(ExitCode::SUCCESS)
}

/// A file to open, which has to be there before a browser starts.
fn checked(path: &Path) -> Result<PathBuf, Failure> {
    if input::is_dash(path) {
        return Err(Failure::usage("the studio opens files, not standard input"));
    }
    let failed = |e: io::Error| Failure::new(format!("{}: cannot read it: {e}", path.display()));
    let is_file = fs::metadata(path).map_err(failed)?.is_file();
    if !is_file {
        return Err(Failure::new(format!("{}: not a file", path.display())));
    }
    fs::File::open(path).map_err(failed)?;
    Ok(path.to_path_buf())
}

fn no_port(port: u16, error: &io::Error) -> Failure {
    let failure = Failure::new(format!("cannot listen on 127.0.0.1, port {port}: {error}"));
    match port {
        0 => failure,
        _ => failure.help("without --port, a free one is taken"),
    }
}

/// What no other page and no other user of this machine can guess.
fn token() -> Result<String, Failure> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes)
        .map_err(|e| Failure::new(format!("the system gives no random numbers: {e}")))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

fn serve(listener: std::net::TcpListener, desk: Arc<Desk>) -> io::Result<()> {
    listener.set_nonblocking(true)?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_io().build()?;
    runtime.block_on(async {
        let listener = tokio::net::TcpListener::from_std(listener)?;
        axum::serve(listener, Router::new().fallback(answer).with_state(desk)).await
    })
}

async fn answer(State(desk): State<Arc<Desk>>, request: Request) -> Response {
    let (method, path) = (request.method(), request.uri().path());
    desk.answer(method, path, request.headers())
}

/// What is served, and to whom.
struct Desk {
    /// `127.0.0.1:PORT` and `localhost:PORT`.
    hosts: [String; 2],
    token: String,
    file: Option<PathBuf>,
}

impl Desk {
    fn new(address: SocketAddr, token: String, file: Option<PathBuf>) -> Self {
        let hosts = [address.to_string(), format!("localhost:{}", address.port())];
        Self { hosts, token, file }
    }

    fn url(&self) -> String {
        format!("http://{}/{}/", self.hosts[0], self.token)
    }

    fn answer(&self, method: &Method, path: &str, headers: &HeaderMap) -> Response {
        if !self.is_ours(headers) {
            return refuse(StatusCode::FORBIDDEN, "asked from another page");
        }
        let rest = path.strip_prefix('/').and_then(|path| path.strip_prefix(&*self.token));
        let Some(name) = rest.and_then(|rest| rest.strip_prefix('/')) else {
            return refuse(
                StatusCode::NOT_FOUND,
                "not here: the address of the studio has a token",
            );
        };
        if !matches!(*method, Method::GET | Method::HEAD) {
            return refuse(StatusCode::METHOD_NOT_ALLOWED, "there is only to read here");
        }
        match (name, &self.file) {
            ("api/file", Some(file)) => open(file),
            ("" | "index.html", _) => self.index(),
            _ => match Page::get(name) {
                Some(part) => respond(part.metadata.mimetype(), part.data.into_owned()),
                None => refuse(StatusCode::NOT_FOUND, "no such part of the studio"),
            },
        }
    }

    /// Whether a request is for this server by its own name, which a page from elsewhere that was made to
    /// resolve to this machine does not have, and from no page of another origin.
    fn is_ours(&self, headers: &HeaderMap) -> bool {
        let is_host = |host: &HeaderValue| self.hosts.iter().any(|ours| ours.as_bytes() == host);
        let is_origin = |origin: &HeaderValue| {
            let host = origin.as_bytes().strip_prefix(b"http://");
            self.hosts.iter().any(|ours| Some(ours.as_bytes()) == host)
        };
        headers.get(HOST).is_some_and(is_host) && headers.get_all(ORIGIN).iter().all(is_origin)
    }

    fn index(&self) -> Response {
        let Some(page) = Page::get("index.html") else {
            return refuse(StatusCode::NOT_FOUND, "no page");
        };
        let mut text = String::from_utf8_lossy(&page.data).into_owned();
        if self.file.is_some() {
            text = text.replacen("<head>", &format!("<head>{SERVED}"), 1);
        }
        respond("text/html; charset=utf-8", text.into_bytes())
    }
}

/// The file as it is now: a reload shows what another program has written to it since.
fn open(file: &Path) -> Response {
    match fs::read(file) {
        Ok(bytes) => {
            let mut response = respond("application/octet-stream", bytes);
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            if let Ok(name) = HeaderValue::from_str(&percent_encoded(&name)) {
                response.headers_mut().insert(HeaderName::from_static("x-file-name"), name);
            }
            response
        }
        Err(e) => {
            refuse(StatusCode::NOT_FOUND, &format!("{}: cannot read it: {e}", file.display()))
        }
    }
}

fn percent_encoded(text: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~".contains(&byte);
    let encode = |byte| if plain(byte) { char::from(byte).into() } else { format!("%{byte:02X}") };
    text.bytes().map(encode).collect()
}

fn refuse(status: StatusCode, why: &str) -> Response {
    let mut response = respond("text/plain; charset=utf-8", why.as_bytes().to_vec());
    *response.status_mut() = status;
    response
}

fn respond(kind: &str, body: Vec<u8>) -> Response {
    let headers = [
        (CONTENT_TYPE, kind),
        (CONTENT_SECURITY_POLICY, POLICY),
        (X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (REFERRER_POLICY, "no-referrer"),
        (CACHE_CONTROL, "no-store"),
        (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
        (HeaderName::from_static("cross-origin-embedder-policy"), "require-corp"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    ];
    (headers, Body::from(body)).into_response()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn desk() -> Desk {
        Desk::new(SocketAddr::from((Ipv4Addr::LOCALHOST, 4711)), "abc".into(), None)
    }

    fn status(path: &str, headers: &[(HeaderName, &str)]) -> StatusCode {
        let list = headers.iter().map(|(k, v)| (k.clone(), HeaderValue::from_str(v).unwrap()));
        desk().answer(&Method::GET, path, &list.collect()).status()
    }

    #[test]
    fn nobody_else_is_answered() {
        let own = (HOST, "127.0.0.1:4711");
        for headers in [
            vec![],
            vec![(HOST, "127.0.0.1")],
            vec![(HOST, "example.org:4711")],
            vec![own.clone(), (ORIGIN, "http://example.org")],
            vec![own.clone(), (ORIGIN, "null")],
            vec![own.clone(), (ORIGIN, "https://127.0.0.1:4711")],
        ] {
            assert_eq!(status("/abc/nothing", &headers), StatusCode::FORBIDDEN, "{headers:?}");
        }
        for path in ["/", "/abc", "/abd/", "/ab/c/", "//abc/", "/abc/../../Cargo.toml"] {
            assert_eq!(status(path, std::slice::from_ref(&own)), StatusCode::NOT_FOUND, "{path}");
        }
    }

    #[test]
    fn there_is_no_file_unless_one_was_named() {
        assert_eq!(status("/abc/api/file", &[(HOST, "localhost:4711")]), StatusCode::NOT_FOUND);
    }

    #[test]
    fn only_reading_is_allowed() {
        let headers = [(HOST, HeaderValue::from_static("localhost:4711"))].into_iter().collect();
        let status = desk().answer(&Method::POST, "/abc/", &headers).status();
        assert_eq!(status, StatusCode::METHOD_NOT_ALLOWED);
    }

    #[test]
    fn names_are_fit_for_a_header() {
        assert_eq!(percent_encoded("zwei Äpfel.obj"), "zwei%20%C3%84pfel.obj");
    }

    #[test]
    fn tokens_differ() {
        let (a, b) = (token().unwrap(), token().unwrap());
        assert!(a != b && a.len() == 32);
    }
}
