//! The `fairform` command.

mod args;
mod commands;
mod console;
mod failure;
mod input;
mod models;
mod rules;
mod surface;

use std::process::ExitCode;

use clap::Parser;

use args::{Args, Command};
use console::Console;
use failure::Failure;

fn main() -> ExitCode {
    let args = Args::parse();
    let console = Console::new(args.quiet, args.verbose, args.json);
    match run(&args, &console) {
        Ok(code) => code,
        Err(failure) => {
            console.fail(&failure);
            ExitCode::from(failure.code)
        }
    }
}

fn run(args: &Args, console: &Console) -> Result<ExitCode, Failure> {
    // What is being written lies in a temporary file until it is whole; that goes, and nothing else
    // is to be put in order.
    ctrlc::set_handler(|| fairform_io::discard_pending_then(|| std::process::exit(130)))
        .map_err(|e| Failure::new(format!("cannot watch for Ctrl-C: {e}")))?;
    if let Some(threads) = args.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads.get())
            .build_global()
            .map_err(|e| Failure::new(format!("cannot start {threads} threads: {e}")))?;
    }
    match &args.command {
        Command::Fit(args) => commands::fit::run(args, console),
        Command::Refine(args) => commands::refine::run(args, console),
        Command::Limit(args) => commands::limit::run(args, console),
        Command::Info(args) => commands::info::run(args, console),
        Command::Convert(args) => commands::convert::run(args, console),
        Command::Repair(args) => commands::repair::run(args, console),
        Command::Compare(args) => commands::compare::run(args, console),
        Command::Render(args) => commands::render::run(args, console),
        Command::Curve(args) => commands::curve::run(args, console),
        Command::Streamline(args) => commands::streamline::run(args, console),
        Command::Studio(args) => commands::studio::run(args, console),
        Command::Completions { shell } => commands::completions::run(*shell, console),
    }
}
