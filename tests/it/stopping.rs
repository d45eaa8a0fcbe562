//! Stopping in the middle: from a library by whoever watches, from the command line by Ctrl-C.

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};

use boresight::calibrate::seam::{InputError, Settings};
use boresight::procedures;
use boresight::watch::{Unwatched, Watch};

/// Stops a job when it is asked for the `left`-th time.
struct After {
    left: AtomicUsize,
    steps: Mutex<Vec<String>>,
    counts: Mutex<Vec<(usize, usize)>>,
}

impl After {
    fn asked(times: usize) -> Self {
        Self {
            left: AtomicUsize::new(times),
            steps: Mutex::default(),
            counts: Mutex::default(),
        }
    }
}

impl Watch for After {
    fn step(&self, what: &str) {
        self.steps.lock().expect("steps").push(what.to_owned());
    }

    fn counted(&self, done: usize, of: usize) {
        self.counts.lock().expect("counts").push((done, of));
    }

    fn stopped(&self) -> bool {
        let less = |left: usize| Some(left.saturating_sub(1));
        self.left.fetch_update(SeqCst, SeqCst, less) == Ok(0)
    }
}

fn thin(name: &str) -> (tempfile::TempDir, std::path::PathBuf) {
    let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/scenarios");
    let scenario = procedures::scenario(&scenario.join(name)).expect("a scenario");
    let folder = tempfile::tempdir().expect("folder");
    let written = scenario.write(1, folder.path(), &Unwatched);
    written.expect("a survey");
    let survey = folder.path().join("survey.toml");
    (folder, survey)
}

#[test]
fn whoever_watches_stops_a_calibration_wherever_it_is() {
    for name in ["single-pass-thin.toml", "seabed-thin.toml"] {
        let (_folder, survey) = thin(name);
        let calibrated =
            |watch: &dyn Watch| boresight::calibrate_with(&survey, &Settings::default(), watch);
        let never = After::asked(usize::MAX);
        let whole = calibrated(&never).expect("a result");
        let asked = usize::MAX - never.left.load(SeqCst);
        let steps = never.steps.into_inner().expect("steps");
        assert!(asked > 30 && !steps.is_empty(), "{name}: {asked} {steps:?}");
        let counts = never.counts.into_inner().expect("counts");
        assert!(
            counts.iter().all(|(done, of)| done < of) && !counts.is_empty(),
            "{name}"
        );
        for share in 0..12 {
            let ended = calibrated(&After::asked(share * asked / 12));
            assert!(
                matches!(ended, Err(InputError::Stopped(_))),
                "{name} {share}"
            );
        }
        // one that was stopped leaves no trace in the next
        let again = calibrated(&Unwatched).expect("a result");
        assert!(again.result == whole.result, "{name}");
    }
}

#[cfg(all(unix, feature = "cli"))]
mod command {
    use super::*;
    use std::collections::BTreeSet;
    use std::process::{Child, Command, Stdio};
    use std::time::{Duration, Instant};

    fn begun(words: &[&str], folder: &Path) -> Child {
        Command::new(assert_cmd::cargo::cargo_bin!("boresight"))
            .args(words)
            .current_dir(folder)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program runs")
    }

    /// Everything below a folder, by name.
    fn below(folder: &Path) -> BTreeSet<String> {
        let mut found = BTreeSet::new();
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            found.insert(path.to_string_lossy().into_owned());
            if path.is_dir() {
                found.extend(below(&path));
            }
        }
        found
    }

    /// Ctrl-C at ten moments of each command: it ends at once with 130 and one sentence, and leaves either what was there before or
    /// all that the command makes.
    #[test]
    fn ctrl_c_ends_every_command_at_once_and_leaves_nothing_half_done() {
        let (folder, survey) = thin("three-pass-thin.toml");
        let [survey, place] = [&survey, folder.path()].map(|p| p.to_string_lossy().into_owned());
        let scenarios = format!("{}/models/scenarios", env!("CARGO_MANIFEST_DIR"));
        let scenario = format!("{scenarios}/three-pass-thin.toml");
        // the thinned one is simulated before anybody could stop it
        let large = format!("{scenarios}/prototype.toml");
        let commands: [&[&str]; 5] = [
            &["calibrate", &survey, "--out", "out"],
            &["check", &survey],
            &["simulate", &large, "--out", "out"],
            &["plan", &scenario, "--out", "out"],
            &["demo", "--out", "out"],
        ];
        for words in commands {
            let work = tempfile::tempdir_in(&place).expect("folder");
            let begin = Instant::now();
            let whole = begun(words, work.path())
                .wait_with_output()
                .expect("an end");
            let takes = begin.elapsed();
            assert!(matches!(whole.status.code(), Some(0 | 1)), "{words:?}");
            let all = below(work.path()).len();
            let mut interrupted = 0;
            for moment in 0..10 {
                let work = tempfile::tempdir_in(&place).expect("folder");
                let child = begun(words, work.path());
                std::thread::sleep(Duration::from_millis(30) + takes * moment / 12);
                let mut kill = Command::new("kill");
                let sent = kill.args(["-INT", &child.id().to_string()]).status();
                let (sent, at) = (sent.expect("kill").success(), Instant::now());
                let output = child.wait_with_output().expect("an end");
                let code = output.status.code();
                if !sent || matches!(code, Some(0 | 1)) {
                    continue;
                }
                interrupted += 1;
                let said = String::from_utf8_lossy(&output.stderr).into_owned();
                assert_eq!(code, Some(130), "{words:?}: {said}");
                assert_eq!(
                    said,
                    "boresight: stopped by Ctrl-C; nothing was left half written\n"
                );
                // 0.3 s on an idle machine; others run beside this test
                assert!(at.elapsed() < Duration::from_secs(3), "{words:?}");
                let left = below(work.path());
                let temporary = |name: &String| name.ends_with(".tmp") || name.ends_with(".tmp.d");
                assert!(!left.iter().any(temporary), "{left:?}");
                // the demo makes its survey first, and marks its folder
                assert!(
                    words[0] == "demo" || left.is_empty() || left.len() == all,
                    "{left:?}"
                );
            }
            assert!(interrupted > 3, "{words:?}: {interrupted} of 10");
        }
    }
}
