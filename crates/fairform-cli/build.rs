//! The page of the studio is part of the command: a new page makes a new command.

fn main() {
    println!("cargo::rerun-if-changed=../../studio/dist");
}
