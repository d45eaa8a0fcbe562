//! The pages for users do what they say: every command in them is one that the program takes, and the pool's tutorial leads from a
//! renamed export in other units to a card.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::{run, simulated, words};

fn page_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn page(name: &str) -> String {
    std::fs::read_to_string(page_path(name)).expect("a page")
}

/// The blocks of a kind, in order.
fn blocks(page: &str, kind: &str) -> Vec<String> {
    let begin = format!("```{kind}\n");
    let ends = |line: &str| line.trim() == "```";
    let mut all = vec![];
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        if format!("{}\n", line.trim()) == begin {
            let block = lines.by_ref().take_while(|line| !ends(line));
            all.push(block.map(|line| line.to_owned() + "\n").collect());
        }
    }
    all
}

/// Commands that stand in blocks or between backticks, without what follows them in a shell.
fn commands(page: &str) -> Vec<String> {
    let in_blocks = blocks(page, "sh").concat();
    let inline = page.split('`').skip(1).step_by(2);
    let lines = in_blocks.lines().map(str::trim).chain(inline);
    let ours = lines.filter(|line| line.starts_with("boresight "));
    let bare = |line: &str| line.split(['#', '>', '|']).next().unwrap_or("").to_owned();
    ours.map(bare).collect()
}

/// Words that stand for what a user types.
fn typed(word: &str) -> &str {
    match word {
        "NAME" | "PROCEDURE" => boresight::procedures::names()[0],
        "N" => "3",
        "KEY=a,b,c" => "k=1,2",
        word => word.trim_matches('\''),
    }
}

/// Asked for help, the program refuses what stands before it and does nothing else.
#[test]
fn every_command_of_the_pages_is_taken() {
    let folder = tempfile::tempdir().expect("folder");
    let tutorials = std::fs::read_dir(page_path("docs/tutorials")).expect("the folder");
    let mut names: Vec<String> = tutorials
        .map(|file| {
            file.expect("a file")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .filter(|name| name.ends_with(".md"))
        .map(|name| format!("docs/tutorials/{name}"))
        .collect();
    names.sort();
    let others = [
        "README.md",
        "docs/recipes.md",
        "docs/pool.md",
        "docs/scenario.md",
    ];
    let mut count = 0;
    for name in names.iter().map(String::as_str).chain(others) {
        for command in commands(&page(name)) {
            let mut given: Vec<&str> = command.split_whitespace().skip(1).map(typed).collect();
            if given.len() < 2 || command.contains("...") {
                continue;
            }
            given.push("--help");
            let output = run(&given, folder.path());
            assert_eq!(
                output.status.code(),
                Some(0),
                "{name}: {command}: {}",
                words(&output)
            );
            count += 1;
        }
    }
    assert!(count > 25, "{count} commands found");
}

/// The export of the tutorial: semicolons, radians, feet, names of its own.
fn exported(soundings: &str) -> String {
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |k: usize| fields[k].parse::<f64>().expect("a number");
        let (angle, feet) = (number(3).to_radians(), number(5) / 0.3048);
        format!(
            "{};{};{};{angle:.9};{feet:.5}\n",
            fields[0], fields[1], fields[2]
        )
    };
    let rows: String = soundings.lines().skip(1).map(row).collect();
    format!("Epoch [s];Ping No;Beam No;Beam Angle [rad];Range [ft]\n{rows}")
}

fn shell(script: &str, folder: &Path) -> bool {
    let mut command = Command::new("sh");
    command.arg("-c").arg(script).current_dir(folder);
    command.status().is_ok_and(|status| status.success())
}

#[test]
fn the_pool_s_tutorial_leads_to_a_card_for_sis() {
    let scenario = page("models/scenarios/three-pass-thin.toml");
    let folder = simulated(&scenario);
    let survey: PathBuf = folder.path().join("survey");
    if !shell("awk 'BEGIN { exit 0 }'", &survey) {
        println!("skipped: no awk");
        return;
    }
    let page = page("docs/tutorials/pool.md");
    let soundings = std::fs::read_to_string(survey.join("multibeam.csv")).expect("soundings");
    std::fs::write(survey.join("export.txt"), exported(&soundings)).expect("written");
    std::fs::remove_file(survey.join("multibeam.csv")).expect("removed");
    let convert = &blocks(&page, "sh")[0];
    assert!(convert.starts_with("awk") && shell(convert, &survey));
    let text = blocks(&page, "toml")[0].replace("trajectory.out", "trajectory.csv");
    std::fs::write(survey.join("survey.toml"), text).expect("written");
    let check = run(&["check", "survey.toml"], &survey);
    assert_eq!(check.status.code(), Some(0), "{}", words(&check));
    let found = run(&["calibrate", "survey.toml", "--export", "sis"], &survey);
    assert_eq!(found.status.code(), Some(0), "{}", words(&found));
    let read = |name: &str| std::fs::read_to_string(survey.join(name)).expect("a file");
    assert!(read("three-pass/card-sis.txt").contains("Kongsberg SIS"));
    let json =
        |name: &str| -> serde_json::Value { serde_json::from_str(&read(name)).expect("JSON") };
    let (result, truth) = (json("three-pass/result.json"), json("truth.json"));
    for (k, name) in ["lx", "ly", "lz"].iter().enumerate() {
        let all = result["solutions"]["joint"]["parameters"]
            .as_array()
            .expect("parameters");
        let found = all.iter().find(|p| p["name"] == *name).expect("the arm");
        let off =
            found["value"].as_f64().expect("m") - truth["lever_arm_m"][k].as_f64().expect("m");
        // one in a million by chance
        let sigmas = off / found["sigma"].as_f64().expect("m");
        assert!(sigmas.abs() < 5.0, "{name}: {off} m, {sigmas} sigmas");
    }
}

/// The values of a card in Kongsberg's sense are the calibrated mounting's: pitch and heading the same numbers, forward before starboard.
#[test]
fn the_seabed_s_tutorial_leads_to_a_card_for_sis() {
    let folder = simulated(&page("models/scenarios/seabed-thin.toml"));
    let survey = folder.path().join("survey");
    let given = ["calibrate", "survey.toml", "--method", "joint"];
    let found = run(
        &[&given[..], &["--export", "sis", "--out", "found"]].concat(),
        &survey,
    );
    assert_eq!(found.status.code(), Some(0), "{}", words(&found));
    let read = |name: &str| std::fs::read_to_string(survey.join("found").join(name)).expect(name);
    let (card, result) = (read("card-sis.txt"), read("result.json"));
    let result: serde_json::Value = serde_json::from_str(&result).expect("JSON");
    let mounting = &result["solutions"]["joint"]["mountings"][0];
    let entered = |field: &str| -> f64 {
        let line = card.lines().find(|l| l.trim_start().starts_with(field));
        let words = line.expect(field).split_whitespace().nth(2);
        words.expect("a value").parse().expect("a number")
    };
    // the card's four decimals
    let agrees = |field: &str, value: &serde_json::Value| {
        let off = entered(field) - value.as_f64().expect("a number");
        assert!(off.abs() < 6e-5, "{field}: {off} in\n{card}");
    };
    agrees("Pitch,", &mounting["mounting_deg"]["pitch"]);
    agrees("Heading,", &mounting["mounting_deg"]["heading"]);
    agrees("X,", &mounting["lever_arm_m"][1]);
    agrees("Y,", &mounting["lever_arm_m"][0]);
}
