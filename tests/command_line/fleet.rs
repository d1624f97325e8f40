//! `ballrace fleet`: a table of machines to a table of outcomes, whatever is wrong with one of them and whenever it is stopped.

use crate::support::{Answer, DEMO_SCENE, DIAGNOSED, Sandbox, TURN, numbers, recorded, scene, short_recording};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::RowAccessor;
use serde_json::Value;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;
use std::time::{Duration, Instant};

/// A limit of the 1X amplitude on every radial probe.
fn limit(max: &str) -> String {
    format!("\n[[limit]]\nindicator = \"1X\"\nmax = \"{max}\"\n")
}

fn fleet(sandbox: &Sandbox, output: &str, more: &[&str]) -> (Answer, Vec<Value>) {
    let args = [&["fleet", "machines.csv", "-o", output, "--format", "json"], more].concat();
    let answer = sandbox.run(&args);
    assert!(matches!(answer.code, Some(0 | 3)) && answer.err.is_empty(), "{answer:?}");
    let rows = answer.json();
    (answer, rows)
}

/// Machine and state of each row.
fn states(rows: &[Value]) -> Vec<(&str, &str)> {
    rows.iter().map(|row| (row["machine"].as_str().unwrap(), row["state"].as_str().unwrap())).collect()
}

/// Machines and recordings in the Parquet files of a folder, each as often as it stands there.
fn stored(folder: &Path) -> Vec<(String, String)> {
    let mut keys = vec![];
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|end| end != "parquet") {
            continue;
        }
        let file = SerializedFileReader::new(std::fs::File::open(path).unwrap()).unwrap();
        let fields = file.metadata().file_metadata().schema().get_fields();
        let at = |name: &str| fields.iter().position(|field| field.name() == name).unwrap();
        let (machine, recording) = (at("machine"), at("recording"));
        let key = |row: parquet::record::Row| {
            (row.get_string(machine).unwrap().clone(), row.get_string(recording).unwrap().clone())
        };
        keys.extend(file.get_row_iter(None).unwrap().map(|row| key(row.unwrap())));
    }
    keys.sort();
    keys
}

/// Numbers of new and stored rows in the last lines of the text.
fn evaluated(answer: &Answer) -> [usize; 2] {
    let line = answer.out.lines().find_map(|line| line.strip_prefix("Evaluated: ")).unwrap();
    let words: Vec<&str> = line.split(' ').collect();
    let [new, .., old, _, _, _, _] = words.as_slice() else { panic!("{line}") };
    [new, old].map(|count| count.parse().unwrap())
}

#[test]
fn states_are_those_of_replay_and_a_bad_machine_stops_no_other() {
    let sandbox = Sandbox::rig();
    sandbox.put("spall.csv", std::fs::read(recorded("outer-spall.csv")).unwrap());
    sandbox.put("twenty.csv", short_recording(DIAGNOSED));
    sandbox.put("limited.toml", DEMO_SCENE.to_owned() + &limit("0.01 um"));
    sandbox.put("broken.toml", scene(&[("mass = \"6 kg\"", "mass = \"6 kgs\"")]));
    sandbox.put("fast.toml", scene(&[("speed = \"3000 rpm\"", "speed = \"9000 rpm\"")]));
    let text = DEMO_SCENE.replace('"', "\"\"");
    let table = format!(
        "machine,scene,recording,hall\nfan/1,scene.toml,,A\nfan 1,\"{text}\",,A\nmill,scene.toml,spall.csv,<B>\n\
         saw,limited.toml,twenty.csv,A\nlost,scene.toml,nowhere.csv,B\ntypo,broken.toml,,B\nwrong,fast.toml,,B\n"
    );
    sandbox.put("machines.csv", table);
    let (answer, rows) = fleet(&sandbox, "out", &[]);
    assert_eq!(answer.code, Some(3));
    let expected = [
        ("fan/1", "normal"),
        ("fan 1", "normal"),
        ("mill", "fault"),
        ("saw", "limit"),
        ("lost", "error"),
        ("typo", "error"),
        ("wrong", "implausible"),
    ];
    assert_eq!(states(&rows), expected);
    // Verdicts and diagnoses are those of a replay.
    let mill = sandbox.replay("scene.toml", &["--recording", "spall.csv"]);
    assert_eq!(rows[2]["verdict"], mill["verdict"]);
    let (found, expected) = (&rows[2]["diagnoses"][0], &mill["findings"][0]);
    assert_eq!((&found["fault"], &found["bearing"]), (&expected["kind"], &expected["bearing"]));
    assert_eq!(found["size_unit"], "um");
    let size = |value: &Value| value.as_f64().unwrap();
    assert!((size(&found["size"]) - size(&expected["depth_um"]["value"])).abs() < 1e-7);
    let crossed = rows[3]["indicators"].as_array().unwrap().iter().filter(|one| one["crossed"] == true);
    assert!(crossed.clone().count() > 0 && crossed.clone().all(|one| one["value"].as_f64() > one["limit"].as_f64()));
    assert!(rows[4]["error"].as_str().unwrap().contains("nowhere.csv"), "{}", rows[4]);
    assert!(rows[5]["error"].as_str().unwrap().contains("broken.toml:9: rotor.mass"), "{}", rows[5]);
    assert_eq!(rows[2]["tags"]["hall"], "<B>");
    // Every outcome has its report, and the overview its link.
    let mut reports: Vec<String> = std::fs::read_dir(sandbox.path("out/reports"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    reports.sort();
    assert_eq!(reports.len(), 5, "{reports:?}");
    let page = sandbox.read("out/index.html");
    assert!(reports.iter().all(|name| page.contains(&format!("href=\"reports&#x2f;{name}\""))), "{reports:?}");
    assert!(page.contains("hall: &lt;B&gt;") && !page.contains("<B>"));
    let place = |machine: &str| page.rfind(&format!(">{machine}<")).unwrap();
    assert!(place("saw") < place("mill") && place("mill") < place("wrong") && place("wrong") < place("lost"));
    assert!(place("lost") < place("fan 1"));
    assert_eq!(stored(&sandbox.path("out/outcomes")).len(), rows.len());

    // A second start computes nothing; one file that changes and one that appears are read again.
    let args = ["fleet", "machines.csv", "-o", "out"];
    assert_eq!(evaluated(&sandbox.run(&args)), [0, 7]);
    sandbox.put("nowhere.csv", short_recording(8 * TURN));
    sandbox.put("twenty.csv", short_recording(8 * TURN));
    let (_, again) = fleet(&sandbox, "out", &[]);
    assert_eq!([&again[3]["state"], &again[4]["state"]], ["normal", "normal"]);
    assert_eq!(stored(&sandbox.path("out/outcomes")).len(), rows.len());
    std::fs::remove_file(sandbox.path("out/reports/lost-nowhere.html")).unwrap();
    assert_eq!(evaluated(&sandbox.run(&[&args[..], &["--no-report"]].concat())), [0, 7]);
    assert_eq!(evaluated(&sandbox.run(&args)), [1, 6]);
    // CSV has the same rows.
    let csv = sandbox.run(&["fleet", "machines.csv", "-o", "out", "--format", "csv"]).out;
    let first = csv.lines().next().unwrap();
    assert!(first.starts_with("machine,recording,time,state,verdict,error,diagnoses_json,indicators_json,tags_json"));
    assert!(csv.contains("\nlost,nowhere.csv,,normal,"), "{csv}");
}

/// Names from a table that a spreadsheet would take for formulas.
#[test]
fn no_cell_of_csv_is_a_formula() {
    let sandbox = Sandbox::rig();
    let table = "machine,scene,recording,=hall\n\"=cmd|' /C calc'!A0\",scene.toml,healthy.csv,-1+2\n@SUM(1),scene.toml,+x.csv,\n";
    sandbox.put("machines.csv", table);
    let csv = sandbox.run(&["fleet", "machines.csv", "-o", "out", "--format", "csv"]).out;
    assert!(csv.contains("\n'=cmd|' /C calc'!A0,") && csv.contains("\n'@SUM(1),'+x.csv,"), "{csv}");
    for csv in [csv, sandbox.read("out/trends.csv")] {
        let cells = csv.lines().flat_map(|line| line.split(','));
        let formulas: Vec<&str> = cells.filter(|cell| cell.starts_with(['=', '+', '@'])).collect();
        assert!(formulas.is_empty(), "{formulas:?}");
    }
    // The names stay what they are.
    let (_, rows) = fleet(&sandbox, "out", &[]);
    assert_eq!([&rows[0]["machine"], &rows[1]["machine"]], ["=cmd|' /C calc'!A0", "@SUM(1)"]);
    // A column that was written so is found by its name.
    sandbox.put("scene.toml", DEMO_SCENE.replace("\"DE_X_um\"", "\"=DE\""));
    for name in ["=DE", "'=DE"] {
        sandbox.put("healthy.csv", short_recording(8 * TURN).replace(",DE_X_um,", &format!(",{name},")));
        sandbox.done(&["replay", "scene.toml", "--no-report"]);
    }
}

/// Killed at several moments and started again, the rows are those of a run without interruption.
#[test]
fn a_killed_run_continues_without_a_lost_or_doubled_row() {
    let sandbox = Sandbox::rig();
    let recordings = 13;
    let mut table = "machine,scene,recording,time\n".to_owned();
    for i in 0..recordings {
        sandbox.put(&format!("r{i}.csv"), short_recording(4 * TURN + i));
        table += &format!("m{:02},scene.toml,r{i}.csv,2026-01-01\n", i % 8);
    }
    sandbox.put("machines.csv", table + "lost,scene.toml,nowhere.csv,\n");
    let parts = || std::fs::read_dir(sandbox.path("out/outcomes")).map_or(0, |entries| entries.count());
    let args = ["fleet", "machines.csv", "-o", "out", "--jobs", "1"];
    let mut kept = 0;
    for _ in 0..3 {
        let before = parts();
        let mut child = sandbox.command(&args).spawn().unwrap();
        let start = Instant::now();
        // A part is written after two seconds; the kill comes in the work on the next one.
        while parts() <= before && child.try_wait().unwrap().is_none() && start.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(5));
        }
        std::thread::sleep(Duration::from_millis(400));
        // The process may have ended on a fast computer.
        let _ = child.kill();
        child.wait().unwrap();
        let mut rows = stored(&sandbox.path("out/outcomes"));
        // Killed while the parts are replaced by one, the process leaves both.
        rows.dedup();
        assert!(rows.len() >= kept, "a stored row is lost: {} of {kept}", rows.len());
        kept = rows.len();
    }
    let end = sandbox.run(&args);
    let [new, old] = evaluated(&end);
    println!("{old} rows from the killed runs, {new} from the last one");
    assert!(old == kept && kept > 0 && new + old == recordings + 1, "{end:?}");
    let rows_and_distinct = || {
        let keys = stored(&sandbox.path("out/outcomes"));
        let mut distinct = keys.clone();
        distinct.dedup();
        (keys.len(), distinct.len())
    };
    assert_eq!(rows_and_distinct(), (recordings + 1, recordings + 1));
    // As left by a process that is killed while the parts are replaced by one.
    let part = sandbox.path("out/outcomes").read_dir().unwrap().next().unwrap().unwrap().path();
    std::fs::copy(part, sandbox.path("out/outcomes/part-999998.parquet")).unwrap();
    assert_eq!(evaluated(&sandbox.run(&args)), [0, recordings + 1]);
    assert_eq!(rows_and_distinct(), (recordings + 1, recordings + 1));
    let (_, continued) = fleet(&sandbox, "out", &[]);
    let (_, whole) = fleet(&sandbox, "whole", &[]);
    assert_eq!(continued, whole);
    assert_eq!(sandbox.read("out/trends.csv"), sandbox.read("whole/trends.csv"));
    assert_eq!(sandbox.read("out/index.html"), sandbox.read("whole/index.html"));
    let entries = sandbox.path("out/reports").read_dir().unwrap().map(|entry| entry.unwrap().path());
    let rests = entries.filter(|path| path.extension().is_none_or(|end| end != "html")).count();
    assert_eq!(rests, 0, "temporary files are left");
}

/// The first turns of the demonstration with a forward 1X of this amplitude added.
fn unbalanced(amplitude_um: f64, turns: usize) -> String {
    let (header, rows) = numbers(&short_recording(turns * TURN));
    let mut text = header.join(",") + "\n";
    for (i, row) in rows.iter().enumerate() {
        let (sin, cos) = (TAU * i as f64 / TURN as f64).sin_cos();
        let cell = |(name, x): (&String, &f64)| match name {
            name if name.ends_with("_X_um") => format!("{:.4}", x + amplitude_um * cos),
            name if name.ends_with("_Y_um") => format!("{:.4}", x + amplitude_um * sin),
            _ => x.to_string(),
        };
        text += &(header.iter().zip(row).map(cell).collect::<Vec<_>>().join(",") + "\n");
    }
    text
}

/// 1X grows by 0.9 um a day: it crosses 3 um on day 4, and the line through the first three days reaches 3 um within day 3.
#[test]
fn a_growing_unbalance_crosses_its_limit_on_the_right_day() {
    let sandbox = Sandbox::rig();
    sandbox.put("scene.toml", DEMO_SCENE.to_owned() + &limit("3 um"));
    let mut table = "machine,scene,recording,time\n".to_owned();
    // The order of the table does not matter.
    // Seventeen turns are enough for a diagnosis; limits and trends of indicators need none.
    let machines = [("grows", 2..=4, 17), ("will cross", 1..=3, 8)];
    for (machine, days, turns) in machines {
        for day in days.rev() {
            let name = format!("{machine} {day}.csv");
            sandbox.put(&name, unbalanced(0.9 * f64::from(day), turns));
            table += &format!("{machine},scene.toml,{name},2026-03-{day:02}\n");
        }
    }
    sandbox.put("machines.csv", table);
    let answer = sandbox.run(&["fleet", "machines.csv", "-o", "out"]);
    assert_eq!(answer.code, Some(3), "{answer:?}");
    let (header, trends) = {
        let text = sandbox.read("out/trends.csv");
        let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        (lines.next().unwrap(), lines.collect::<Vec<_>>())
    };
    let trend = |machine: &str, kind: &str, name: &str, probe: &str| -> BTreeMap<String, String> {
        let at = |column: &str| header.iter().position(|one| one == column).unwrap();
        let wanted = [(at("machine"), machine), (at("kind"), kind), (at("name"), name), (at("probe"), probe)];
        let row = trends.iter().find(|row| wanted.iter().all(|(i, text)| row[*i] == *text));
        header.iter().cloned().zip(row.unwrap_or_else(|| panic!("{machine} {name}: {trends:#?}")).clone()).collect()
    };
    for probe in ["DE_X_um", "DE_Y_um", "NDE_X_um", "NDE_Y_um"] {
        let grows = trend("grows", "indicator", "1X", probe);
        assert_eq!((grows["crossed_on"].as_str(), grows["crosses_on"].as_str()), ("2026-03-04T00:00:00Z", ""));
        assert_eq!((grows["snapshots"].as_str(), grows["limit"].as_str()), ("3", "3"));
        let slope: f64 = grows["slope_per_day"].parse().unwrap();
        assert!((slope - 0.9).abs() < 0.01, "{slope}");
        let will = trend("will cross", "indicator", "1X", probe);
        assert_eq!(will["crossed_on"], "");
        assert!(will["crosses_on"].starts_with("2026-03-03T"), "{will:?}");
        assert!(will["crosses_earliest"] <= will["crosses_on"] && will["crosses_on"] <= will["crosses_latest"]);
    }
    // The diagnosed unbalance grows with it.
    let size = trend("grows", "diagnosis", "unbalance", "");
    assert!(size["slope_low"].parse::<f64>().unwrap() > 0.0 && size["unit"] == "g mm", "{size:?}");
    let page = sandbox.read("out/index.html");
    assert!(page.contains("crossed on 2026-03-04") && page.contains("expected on 2026-03-03"));
    assert!(page.find(">grows<") < page.find(">will cross<"));
    assert!(answer.out.contains("2 machines, 6 recordings"), "{answer:?}");
}

#[test]
fn a_wrong_table_is_one_error() {
    let sandbox = Sandbox::rig();
    let refused = |table: &str, parts: &[&str]| {
        sandbox.put("machines.csv", table);
        sandbox.refused(&["fleet", "machines.csv", "-o", "out"], 2, parts);
    };
    refused("machine,recording\na,b\n", &["machines.csv:1: missing column \"scene\"", "found machine, recording"]);
    refused(
        "machine,scene\na,scene.toml\nb,scene.toml\na,other.toml\n",
        &["machines.csv:4: repeated machine and recording: \"a\"", "as at machines.csv:2"],
    );
    refused("", &["machines.csv: empty table, expected at least one machine"]);
    refused("machine,scene\n", &["machines.csv: empty table"]);
    refused(
        "machine,scene,time\na,scene.toml,31.01.2026\n",
        &["machines.csv:2: column time: invalid value: \"31.01.2026\"", "expected an ISO 8601 date"],
    );
    refused("machine,scene\na\n", &["machines.csv:2: wrong number of cells: 1, expected 2"]);
    refused("PAR1 is no Parquet", &["machines.csv: unreadable table"]);
    sandbox.refused(&["fleet", "absent.csv", "-o", "out"], 2, &["absent.csv: this file cannot be read"]);
    sandbox.put("machines.csv", "machine,scene\na,scene.toml\n");
    sandbox.refused(&["fleet", "machines.csv", "-o", "scene.toml"], 1, &["scene.toml"]);
}

/// Prints the processor time of single replays over that of a fleet with one job.
#[cfg(target_os = "linux")]
#[test]
#[ignore = "slow: replays 200 recordings of one second twice; tests/run --all runs it"]
fn long_a_fleet_costs_no_more_than_its_replays() {
    const MACHINES: usize = 200;
    /// User time of the children of this process that have ended, s.
    fn user_time() -> f64 {
        let stat = std::fs::read_to_string("/proc/self/stat").unwrap();
        // Field 16 of proc(5) in clock ticks, of which Linux has 100 a second.
        let fields: Vec<&str> = stat.rsplit_once(')').unwrap().1.split_whitespace().collect();
        fields[13].parse::<f64>().unwrap() / 100.0
    }
    let sandbox = Sandbox::with(DEMO_SCENE, crate::support::HEALTHY_RECORDING);
    let rows: String = (0..MACHINES).map(|i| format!("m{i},scene.toml\n")).collect();
    sandbox.put("machines.csv", format!("machine,scene\n{rows}"));
    let timed = |args: &[&str]| {
        let before = user_time();
        assert_eq!(sandbox.run(args).code, Some(0));
        user_time() - before
    };
    let fleet = timed(&["fleet", "machines.csv", "-o", "out", "--jobs", "1"]);
    let single: f64 = (0..MACHINES).map(|_| timed(&["replay", "scene.toml"])).sum();
    println!("{MACHINES} machines: fleet {fleet:.2} s, single replays {single:.2} s, ratio {:.3}", single / fleet);
}
