//! Exit codes, and files that are whole or not there at all.

use std::fs;
use std::io::Write;
use std::process::Stdio;

use crate::common::{Folder, data};

fn given(folder: &Folder, path: &str, name: &str) {
    fs::copy(data(path), folder.path(name)).unwrap();
}

fn icosahedron() -> Folder {
    let folder = Folder::new();
    given(&folder, "meshes/tri_closed/icosahedron.off", "in.off");
    folder
}

#[test]
fn code_2_for_wrong_usage() {
    let folder = icosahedron();
    for arguments in [
        "",
        "nothing",
        "fit in.off",
        "fit in.off -o out.ply --scheme nothing",
        "fit in.off -o out.ply --method nothing",
        "fit in.off -o out.ply --norm nothing",
        "fit in.off -o out.ply --tolerance 0",
        "fit in.off -o out.ply --iterations -1",
        "fit in.off -o out.ply --levels many",
        "fit in.off -o out.ply --threads 0",
        "fit in.off -o out.ply --threads 1000000",
        "fit in.off -o out.nothing",
        "fit in.off -o out",
        "fit in.off -o -",
        "fit - -o out.ply",
        "fit in.off -o out.ply --control out.ply",
        "fit in.off -o out.ply --report out.json --plot out.json",
        "fit in.off -o - --to ply --json",
        "refine in.off",
        "refine in.off -o - --to ply --json",
        "limit in.off -o out.nothing",
        "convert in.off -o out.nothing",
        "repair in.off -o out.off",
        "repair in.off -o out.off --weld -1",
        "render in.off -o out.jpg",
        "render in.off -o out.png --size 100",
        "render in.off -o out.png --view nowhere",
        "completions nothing",
    ] {
        let run = folder.run(arguments);
        assert_eq!(run.code, Some(2), "fairform {arguments}: {}", run.stderr);
        assert_eq!(folder.names(), ["in.off"], "fairform {arguments}");
    }
}

#[test]
fn code_1_for_bad_input() {
    let folder = icosahedron();
    folder.write("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n");
    folder.write("folder.obj", "");
    fs::create_dir(folder.path("empty")).unwrap();
    for (arguments, words) in [
        ("fit none.obj -o out.ply", "none.obj"),
        ("fit bad.obj -o out.ply", "bad.obj: line 4: "),
        ("info bad.obj", "bad.obj: line 4: "),
        ("fit in.off -o none/out.ply", "there is no folder none"),
        ("fit in.off -o out.ply --report none/report.json", "there is no folder none"),
        ("convert in.off -o empty --to ply", "empty"),
        ("fit in.off -o out.ply --levels 99", "99 levels"),
        ("render in.off -o out.png --size 99999x99999", "99999x99999"),
    ] {
        folder.fails(arguments, 1, words);
        let names = ["bad.obj", "empty", "folder.obj", "in.off"];
        assert_eq!(folder.names(), names, "fairform {arguments}");
    }
    let run = folder.run("info bad.obj --json");
    assert_eq!(run.code, Some(1));
    assert!(run.json()["error"].as_str().unwrap().contains("bad.obj: line 4: "));
}

#[test]
fn code_1_where_the_tolerance_is_not_reached() {
    let folder = icosahedron();
    let run = folder.run("fit in.off -o out.ply --tolerance 1e-12 --iterations 2 --report r.json");
    assert_eq!(run.code, Some(1));
    assert!(run.stderr.contains("not converged"), "{}", run.stderr);
    assert_eq!(folder.json("r.json")["converged"], false);
    assert_eq!(folder.json("r.json")["stages"][0]["history"].as_array().unwrap().len(), 3);
    // What was reached is there to be looked at.
    assert_eq!(folder.mesh("out.ply").positions.len(), 642);
    // A count without a tolerance is made, and that is all that was asked.
    folder.ok("fit in.off -o out.ply --iterations 2");
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let folder = Folder::new();
    given(&folder, "meshes/tri_open/lego_1loop.ply", "open.ply");
    given(&folder, "meshes/tri_closed/homer.off", "closed.off");
    for (input, method) in [("open.ply", "auto"), ("closed.off", "cg"), ("closed.off", "plain")] {
        for threads in [1, 3] {
            folder.ok(&format!(
                "fit {input} -o {threads}.ply --control c{threads}.obj --plot {threads}.svg \
                 --report {threads}.json --levels 2 --limit --method {method} --threads {threads}"
            ));
        }
        for (one, three) in [("1.ply", "3.ply"), ("c1.obj", "c3.obj"), ("1.svg", "3.svg")] {
            assert!(folder.bytes(one) == folder.bytes(three), "{input}: {one} and {three}");
        }
        let [one, three] = ["1.json", "3.json"].map(|name| {
            let mut report = folder.json(name);
            let seconds = report.as_object_mut().unwrap().remove("seconds").unwrap();
            for phase in ["read", "prepare", "solve", "refine", "write"] {
                assert!(seconds[phase].as_f64().unwrap() >= 0.0, "{phase}");
            }
            report
        });
        assert_eq!(one, three, "{input}");
    }
    for threads in [1, 3] {
        folder.ok(&format!(
            "render closed.off -o {threads}.png --size 320x240 --wireframe --threads {threads}"
        ));
    }
    assert!(folder.bytes("1.png") == folder.bytes("3.png"));
}

#[test]
fn standard_input_and_output() {
    let folder = icosahedron();
    folder.ok("fit in.off -o file.ply --levels 1");
    let mut command = folder.command("fit - --from off -o - --to ply --levels 1");
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(&folder.bytes("in.off")).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    assert_eq!(output.stdout, folder.bytes("file.ply"));

    let limit = folder.ok("limit in.off -o -").json();
    assert_eq!(limit["points"].as_array().unwrap().len(), 12);
    let info = folder.ok("info in.off --json").json();
    assert_eq!((&info["manifold"], &info["edges"]), (&true.into(), &30.into()));
    let result = folder.ok("fit in.off -o file.ply --json").json();
    assert_eq!(result["converged"], true);
}

#[test]
fn gzip_by_name() {
    let folder = icosahedron();
    for format in ["obj", "off", "ply", "stl", "gltf", "glb"] {
        folder.ok(&format!("fit in.off -o plain.{format}"));
        folder.ok(&format!("fit in.off -o packed.{format}.gz"));
        assert_eq!(folder.bytes(&format!("packed.{format}.gz"))[..2], [0x1f, 0x8b]);
        let packed = folder.mesh(&format!("packed.{format}.gz"));
        assert_eq!(folder.mesh(&format!("plain.{format}")), packed);
    }
}

#[test]
fn the_sample() {
    let folder = Folder::new();
    folder.ok("fit");
    assert_eq!(folder.names(), ["fairform-sample.ply", "fairform-sample.png"]);
    assert!(folder.mesh("fairform-sample.ply").normals.is_some());
    assert!(folder.bytes("fairform-sample.png").starts_with(b"\x89PNG\r\n\x1a\n"));
}

#[test]
fn pictures_have_the_size_that_was_asked_for() {
    let folder = icosahedron();
    folder.ok("fit in.off -o surface.ply --levels 1");
    folder.ok("render in.off surface.ply -o picture.png --size 200x100 --view 30,10 --points");
    let png = folder.bytes("picture.png");
    let side = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap());
    assert_eq!((side(16), side(20)), (200, 100));
}

#[test]
fn help_and_completions() {
    let folder = Folder::new();
    let help = |arguments: &str| {
        let run = folder.command(arguments).env("COLUMNS", "80").output().unwrap();
        assert!(run.status.success());
        String::from_utf8(run.stdout).unwrap()
    };
    let all = help("--help");
    for command in [
        "fit",
        "refine",
        "limit",
        "info",
        "convert",
        "repair",
        "render",
        "curve",
        "streamline",
        "completions",
    ] {
        assert!(all.contains(&format!("\n  {command} ")), "{command}");
        let text = help(&format!("{command} --help"));
        assert!(text.contains("Examples:\n  fairform "), "{text}");
        assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    }
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = folder.ok(&format!("completions {shell}")).stdout;
        assert!(String::from_utf8(script).unwrap().contains("--tolerance"), "{shell}");
    }
}

#[cfg(unix)]
mod unix {
    use std::process::{Child, Command};

    use super::*;

    /// A reader that has seen enough is no failure.
    #[test]
    fn a_closed_pipe() {
        let folder = icosahedron();
        let run = folder.shell("fairform completions zsh | head -1; fairform info in.off | true");
        assert_eq!(run.stderr, "");
    }

    #[test]
    fn a_write_that_fails_keeps_the_old_file() {
        let folder = icosahedron();
        folder.write("out.ply", "old");
        // The shell bounds the size of files and lets the program see the error.
        let run = folder
            .shell("trap '' XFSZ; ulimit -f 8; exec fairform fit in.off -o out.ply --levels 5");
        assert_eq!(run.code, Some(1), "{}", run.stderr);
        assert!(run.stderr.contains("cannot write out.ply"), "{}", run.stderr);
        assert_eq!(folder.bytes("out.ply"), b"old");

        // A format that cannot hold the mesh.
        folder.write("nan.off", "OFF\n3 1 0\n0 0 nan\n1 0 0\n0 1 0\n3 0 1 2\n");
        folder.write("out.glb", "old");
        folder.fails("convert nan.off -o out.glb", 1, "out.glb");
        assert_eq!(folder.bytes("out.glb"), b"old");
        assert_eq!(folder.names(), ["in.off", "nan.off", "out.glb", "out.ply"]);
    }

    fn interrupt(child: &mut Child) {
        let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
        assert!(sent.success());
        assert_eq!(child.wait().unwrap().code(), Some(130));
    }

    #[test]
    fn an_interrupt_leaves_nothing_behind() {
        let folder = icosahedron();
        folder.ok("refine in.off -o big.ply --levels 6");
        let arguments = "fit big.ply -o out.obj --control control.obj --levels 3 --quiet";

        // While it reads: it has begun to, once a pipe has taken more than it holds.
        let mut command = folder.command("fit - --from ply -o out.obj");
        let mut child = command.stdin(Stdio::piped()).spawn().unwrap();
        let mut pipe = child.stdin.take().unwrap();
        pipe.write_all(&folder.bytes("big.ply")[..1 << 20]).unwrap();
        interrupt(&mut child);
        assert_eq!(folder.names(), ["big.ply", "in.off"]);

        // While it writes, first the control mesh, then the surface.
        folder.write("out.obj", "old");
        folder.write("control.obj", "old");
        let mut child = folder.command(arguments).spawn().unwrap();
        while !folder.names().iter().any(|name| name.starts_with(".fairform-")) {
            assert!(child.try_wait().unwrap().is_none(), "it ended before it wrote");
        }
        interrupt(&mut child);
        assert_eq!(folder.names(), ["big.ply", "control.obj", "in.off", "out.obj"]);
        assert_eq!(folder.bytes("out.obj"), b"old");

        // While it makes what it writes.
        let mut child = folder.command("refine in.off -o out.obj --levels 10").spawn().unwrap();
        while !folder.names().iter().any(|name| name.starts_with(".fairform-")) {
            assert!(child.try_wait().unwrap().is_none(), "it ended before it wrote");
        }
        interrupt(&mut child);
        assert_eq!(folder.names(), ["big.ply", "control.obj", "in.off", "out.obj"]);
        assert_eq!(folder.bytes("out.obj"), b"old");
    }
}
