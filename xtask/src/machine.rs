//! What a measurement was made on.

use std::fs;
use std::process::Command;
use std::thread::available_parallelism;
use std::time::{SystemTime, UNIX_EPOCH};

use crate::command::{Result, output, root};

/// The processor's name, where the system tells.
pub(crate) fn processor() -> String {
    let linux = || {
        let info = fs::read_to_string("/proc/cpuinfo").ok()?;
        let line = info.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    };
    let mac = || output(Command::new("sysctl").args(["-n", "machdep.cpu.brand_string"])).ok();
    let name = if cfg!(target_os = "macos") { mac() } else { linux() };
    let name = name.unwrap_or_else(|| std::env::consts::ARCH.into());
    let cores = available_parallelism().map_or(1, usize::from);
    format!("{}, {cores} cores", name.trim())
}

/// The data caches, nearest first; `None` where the system does not tell.
pub(crate) fn caches() -> Option<String> {
    let mut caches = Vec::new();
    for entry in fs::read_dir("/sys/devices/system/cpu/cpu0/cache").ok()?.flatten() {
        let read = |name| Some(fs::read_to_string(entry.path().join(name)).ok()?.trim().to_owned());
        if let (Some(level), Some(kind), Some(size)) = (read("level"), read("type"), read("size"))
            && kind != "Instruction"
        {
            caches.push(format!("L{level} {size}"));
        }
    }
    caches.sort();
    (!caches.is_empty()).then(|| caches.join(", "))
}

/// Processes that wanted to run in the last minute, on average.
pub(crate) fn load() -> Option<String> {
    let load = fs::read_to_string("/proc/loadavg").ok()?;
    Some(load.split_whitespace().next()?.to_owned())
}

/// The commit, and whether the tree differs from it.
pub(crate) fn commit() -> Result<String> {
    let git = |args: &[&str]| output(Command::new("git").args(args).current_dir(root()));
    let commit = git(&["rev-parse", "--short=12", "HEAD"])?.trim().to_owned();
    // What is measured does not depend on its own report.
    let changes = git(&["status", "--porcelain", "--", ".", ":!docs"])?;
    Ok(if changes.trim().is_empty() { commit } else { commit + ", with changes" })
}

/// Today in UTC, as year-month-day.
pub(crate) fn today() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |t| t.as_secs());
    let (year, month, day) = date(seconds / 86_400);
    format!("{year}-{month:02}-{day:02}")
}

/// Year, month and day of a day counted from 1970-01-01.
fn date(mut day: u64) -> (u64, u64, u64) {
    let is_leap = |y: u64| y.is_multiple_of(4) && (!y.is_multiple_of(100) || y.is_multiple_of(400));
    let mut year = 1970;
    while day >= 365 + u64::from(is_leap(year)) {
        day -= 365 + u64::from(is_leap(year));
        year += 1;
    }
    let february = 28 + u64::from(is_leap(year));
    let mut month = 1;
    for length in [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30] {
        if day < length {
            break;
        }
        day -= length;
        month += 1;
    }
    (year, month, day + 1)
}

#[cfg(test)]
mod tests {
    use super::date;

    #[test]
    fn days_have_dates() {
        assert_eq!(date(0), (1970, 1, 1));
        assert_eq!(date(11_016), (2000, 2, 29));
        assert_eq!(date(11_017), (2000, 3, 1));
        assert_eq!(date(19_722), (2023, 12, 31));
        assert_eq!(date(20_819), (2027, 1, 1));
    }
}
