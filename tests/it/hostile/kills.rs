//! Kills at any moment and a full disk.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use super::{PROGRAM, accepted, count, fixture, names, refused};

/// Commands that write, with the folder that they write into; all are quick on these files.
const COMMANDS: [&[&str]; 5] = [
    &["simulate", "scenario.toml", "--out", "out"],
    &["calibrate", "survey/survey.toml", "--out", "out"],
    &["budget", "scenario.toml", "--trials", "2", "--out", "out"],
    &["plan", "pool.toml", "--out", "out"],
    &[
        "apply",
        "pool/survey.toml",
        "--calibration",
        "pool-result/result.json",
        "--out",
        "out/points.laz",
    ],
];

fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let read = |name: String| {
        let bytes = std::fs::read(folder.join(&name)).unwrap_or_default();
        (name, bytes)
    };
    names(folder).into_iter().map(read).collect()
}

/// A folder with what the commands read: small scenarios, a survey of each, and a result.
fn kill_folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("folder");
    let scenarios = [
        ("scenario.toml", "usbl-thin", "survey"),
        ("pool.toml", "single-pass-thin", "pool"),
    ];
    for (file, name, survey) in scenarios {
        let scenario = fixture(&format!("models/scenarios/{name}.toml"));
        std::fs::write(folder.path().join(file), scenario).expect("written");
        accepted(folder.path(), &["simulate", file, "--out", survey]);
    }
    accepted(
        folder.path(),
        &["calibrate", "pool/survey.toml", "--out", "pool-result"],
    );
    folder
}

/// Starts a command and kills it after a while.
fn killed(folder: &Path, arguments: &[&str], after: Duration) {
    let mut command = Command::new(PROGRAM);
    command.args(arguments).current_dir(folder);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = command.spawn().expect("started");
    std::thread::sleep(after);
    let _ = child.kill();
    let _ = child.wait();
}

#[test]
fn a_killed_run_leaves_no_half_file_and_the_next_makes_the_same() {
    let kills = count("BORESIGHT_KILLS", 4);
    let folder = kill_folder();
    let out = folder.path().join("out");
    for arguments in COMMANDS {
        let begun = Instant::now();
        accepted(folder.path(), arguments);
        let (whole, length) = (contents(&out), begun.elapsed());
        for k in 0..kills {
            std::fs::remove_dir_all(&out).expect("removed");
            let part = (k as f64 + 0.5) / kills as f64;
            killed(folder.path(), arguments, length.mul_f64(part));
            for (name, bytes) in contents(&out) {
                let good = whole.iter().find(|(n, _)| *n == name);
                let temporary = name.starts_with(".boresight");
                assert!(
                    temporary || good.is_some_and(|g| g.1 == bytes),
                    "{arguments:?}: half a {name}"
                );
            }
            let mut again = arguments.to_vec();
            if out.join("trials").exists() {
                again.push("--resume"); // trials done are kept
            }
            accepted(folder.path(), &again);
            assert!(contents(&out) == whole, "{arguments:?}: {:?}", names(&out));
        }
        std::fs::remove_dir_all(&out).expect("removed");
    }
}

// A FULL DISK

/// A file system of 64 KiB, where root allows one.
struct SmallDisk(PathBuf);

impl SmallDisk {
    fn new(place: &Path) -> Option<Self> {
        let mut mount = Command::new("mount");
        mount
            .args(["-t", "tmpfs", "-o", "size=64k", "tmpfs"])
            .arg(place);
        let mounted = mount.stderr(Stdio::null()).status();
        mounted
            .is_ok_and(|s| s.success())
            .then(|| Self(place.to_owned()))
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.0).status();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_nothing() {
    let folder = kill_folder();
    let place = folder.path().join("disk");
    std::fs::create_dir(&place).expect("folder");
    let Some(_disk) = SmallDisk::new(&place) else {
        eprintln!("skipped: no file system can be mounted here");
        return;
    };
    for arguments in [
        ["calibrate", "survey/survey.toml", "--out", "disk/out"],
        ["simulate", "scenario.toml", "--out", "disk/out"],
    ] {
        let said = refused(folder.path(), &arguments);
        assert!(said.contains("disk/out"), "{said}");
        assert_eq!(names(&place), Vec::<String>::new(), "{arguments:?}");
    }
}
