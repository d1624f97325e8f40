//! `ballrace sweep`: its points are those of `simulate`, and a sweep in parts is the sweep in one.

use crate::support::{DEMO_SCENE, Sandbox, numbers, swap};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::RowAccessor;
use serde_json::Value;

const SPEEDS: &str = "shaft.speed=1000rpm..5000rpm:9";

/// A sandbox with a shipped scene.
fn sandbox(scene: &str) -> Sandbox {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", Sandbox::empty().done(&["scenes", scene]).out);
    sandbox
}

fn sweep(sandbox: &Sandbox, more: &[&str]) -> Value {
    let args = ["sweep", "scene.toml", "--settle", "0.3 s", "--periods", "16", "--format", "json"];
    sandbox.done(&[&args[..], more].concat()).json()
}

/// A column of `NAME.csv`; an empty cell is none.
fn column(sandbox: &Sandbox, file: &str, name: &str) -> Vec<Option<f64>> {
    let text = sandbox.read(file);
    let mut lines = text.lines();
    let at = lines.next().unwrap().split(',').position(|h| h == name).unwrap_or_else(|| panic!("{name} in {text}"));
    lines.map(|line| line.split(',').nth(at).unwrap().parse().ok()).collect()
}

#[test]
fn points_are_those_of_simulate() {
    let sandbox = sandbox("tiwari-balanced");
    let summary = sweep(&sandbox, &["--over", SPEEDS, "-o", "a"]);
    assert_eq!((summary["points"].as_u64(), summary["computed"].as_u64()), (Some(9), Some(9)));
    assert_eq!(sandbox.files(), ["a-sections.csv", "a.csv", "a.html", "a.parquet", "scene.toml"]);
    let speeds = column(&sandbox, "a.csv", "shaft.speed_rpm");
    assert_eq!(speeds[1], Some(1500.0));
    // Confirmed by a second program: 0.05206 and 0.79116 um peak to peak, 7.54058 mean, at 1500 rpm; the sampling is coarser here.
    let at = |name: &str| column(&sandbox, "a.csv", name)[1].unwrap();
    assert!((at("u_peak_to_peak_um") - 0.05206).abs() < 3e-4, "{}", at("u_peak_to_peak_um"));
    assert!((at("v_peak_to_peak_um") - 0.79116).abs() < 2e-3, "{}", at("v_peak_to_peak_um"));
    assert!((at("u_mean_um") - 7.54058).abs() < 1e-4 && at("period") == 1.0);
    // The line holds most of the motion, its multiples the rest.
    assert!((0.5..1.0).contains(&(2.0 * at("v_ball_pass_um") / 0.79116)), "{}", at("v_ball_pass_um"));
    let (header, sections) = numbers(&sandbox.read("a-sections.csv").replace("rest", "0"));
    assert_eq!((header.len(), sections.len()), (5, 9 * 16));
    let page = sandbox.read("a.html");
    assert_eq!(page.matches("<svg").count(), 3);
    for word in ["Response", "Bifurcation", "Waterfall"] {
        assert!(page.contains(word));
    }
}

#[test]
fn parquet_holds_what_the_table_holds() {
    let sandbox = sandbox("tiwari-balanced");
    sweep(&sandbox, &["--over", "shaft.speed=1000rpm,8000rpm", "--over", "bearing.A.radial_play=3um,10um", "-o", "a"]);
    let file = SerializedFileReader::new(std::fs::File::open(sandbox.path("a.parquet")).unwrap()).unwrap();
    let names: Vec<String> =
        file.metadata().file_metadata().schema().get_fields().iter().map(|f| f.name().to_owned()).collect();
    assert_eq!(names.join(","), sandbox.read("a.csv").lines().next().unwrap());
    let which = |name: &str| names.iter().position(|n| n == name).unwrap();
    let mean: Vec<Option<f64>> =
        file.get_row_iter(None).unwrap().map(|row| row.unwrap().get_double(which("u_mean_um")).ok()).collect();
    assert_eq!(mean, column(&sandbox, "a.csv", "u_mean_um"));
    let play = column(&sandbox, "a.csv", "bearing.A.radial_play_um");
    assert_eq!(play, [Some(3.0), Some(3.0), Some(10.0), Some(10.0)]);
}

const RESULTS: [&str; 3] = [".csv", ".parquet", "-sections.csv"];

fn bytes(sandbox: &Sandbox, name: &str) -> Vec<Vec<u8>> {
    RESULTS.map(|end| std::fs::read(sandbox.path(&format!("{name}{end}"))).unwrap()).to_vec()
}

#[test]
fn merged_shards_equal_one_run() {
    let sandbox = sandbox("tiwari-balanced");
    sweep(&sandbox, &["--over", SPEEDS, "-o", "whole"]);
    for shard in ["1/3", "2/3"] {
        sweep(&sandbox, &["--over", SPEEDS, "-o", "parts", "--shard", shard]);
    }
    let merge =
        ["sweep", "scene.toml", "--settle", "0.3 s", "--periods", "16", "--over", SPEEDS, "-o", "parts", "--merge"];
    sandbox.refused(&merge, 1, &["missing 3 of 9 parts"]);
    sweep(&sandbox, &["--over", SPEEDS, "-o", "parts", "--shard", "3/3"]);
    sandbox.done(&merge);
    assert!(bytes(&sandbox, "whole") == bytes(&sandbox, "parts"));
    assert!(sandbox.files().contains(&"parts.shard-3-of-3".to_owned()));
}

#[test]
fn continues_after_an_interruption() {
    let sandbox = sandbox("tiwari-balanced");
    sweep(&sandbox, &["--over", SPEEDS, "-o", "whole"]);
    sweep(&sandbox, &["--over", SPEEDS, "-o", "again", "--shard", "1/1"]);
    // Stopped in the middle of the sixth point's line.
    let journal = sandbox.read("again.shard-1-of-1");
    // A journal of a former version names the direction otherwise.
    assert!(journal.contains("\"direction\":"), "{journal}");
    let journal = journal.replace("\"direction\":", "\"way\":");
    let five: usize = journal.split_inclusive('\n').take(6).map(str::len).sum();
    sandbox.put("again.journal", &journal[..five + 100]);
    // The finished chains are never in one open file alone: a second stop may come while the next run starts.
    std::fs::hard_link(sandbox.path("again.journal"), sandbox.path("first")).unwrap();
    let summary = sweep(&sandbox, &["--over", SPEEDS, "-o", "again"]);
    assert_eq!((summary["computed"].as_u64(), summary["taken_over"].as_u64()), (Some(4), Some(5)));
    assert!(bytes(&sandbox, "whole") == bytes(&sandbox, "again"));
    assert!(!sandbox.files().contains(&"again.journal".to_owned()), "{:?}", sandbox.files());
    assert_eq!(sandbox.read("first"), &journal[..five + 100]);
    // Results of another sweep are not taken for this one's.
    sandbox.put("other.journal", &journal);
    let other = ["sweep", "scene.toml", "--over", "shaft.speed=1000rpm..5000rpm:8", "-o", "other"];
    sandbox.refused(
        &other,
        1,
        &["other.journal: results of another scene, range or measure, expected those of this sweep"],
    );
}

#[test]
fn sweep_up_and_down() {
    let sandbox = sandbox("tiwari-balanced");
    sweep(
        &sandbox,
        &[
            "--over",
            "shaft.speed=2000rpm..4000rpm:3",
            "--over",
            "bearing[0].radial_play=3um,10um",
            "--follow",
            "both",
            "-o",
            "a",
        ],
    );
    let text = sandbox.read("a.csv");
    let direction = |line: &str| line.split(',').take(2).collect::<Vec<_>>().join(" ");
    let directions: Vec<String> = text.lines().skip(1).map(direction).collect();
    let expected =
        ["0 up", "1 up", "2 up", "2 down", "1 down", "0 down", "3 up", "4 up", "5 up", "5 down", "4 down", "3 down"];
    assert_eq!(directions, expected);
}

/// A motion of period one has neighbours that come closer; one that never repeats has neighbours that part.
#[test]
fn lyapunov_exponent_is_positive_for_chaos() {
    let sandbox = sandbox("lioulios-fluctuation");
    let text = sandbox.read("scene.toml");
    let text = text.replace("{ mean = \"2000 rpm\", fluctuation = 0.02, frequency = \"7 Hz\" }", "\"2000 rpm\"");
    sandbox.put("scene.toml", text);
    let at = |speed: &str, play: &str| {
        let (speed, play) = (format!("shaft.speed={speed}"), format!("bearing[0].radial_play={play}"));
        let args = ["sweep", "scene.toml", "--settle", "2 s", "--periods", "512", "--lyapunov", "-o", "a"];
        sandbox.done(&[&args[..], &["--over", &speed, "--over", &play]].concat());
        (column(&sandbox, "a.csv", "lyapunov_per_s")[0].unwrap(), column(&sandbox, "a.csv", "period")[0])
    };
    let (regular, chaotic) = (at("6000rpm", "10um"), at("10000rpm", "20um"));
    println!("exponents, 1/s: period one {:.1}, aperiodic {:.1}", regular.0, chaotic.0);
    // Neighbours of a regular motion come closer at the rate of the damping, c/(2 m) = 200/1.2.
    assert!(regular.1 == Some(1.0) && (regular.0 + 200.0 / 1.2).abs() < 2.0, "{regular:?}");
    assert!(chaotic.1.is_none() && chaotic.0 > 10.0, "{chaotic:?}");
}

#[test]
fn keys_that_cannot_be_swept_are_rejected() {
    let sandbox = sandbox("tiwari-balanced");
    let refused = |over: &str, code: i32, parts: &[&str]| {
        sandbox.refused(&["sweep", "scene.toml", "-o", "a", "--over", over], code, parts);
    };
    refused("shaft.speed", 2, &["--over: invalid range: \"shaft.speed\", expected", "KEY=FROM..TO:COUNT"]);
    refused("shaft.sped=1rpm..2rpm:3", 2, &["shaft.sped", "unknown key (did you mean speed?)"]);
    refused("bearing.B.radial_play=1um..2um:3", 2, &["no such key in the scene: \"bearing.B.radial_play\""]);
    refused("shaft.speed=1mm..2mm:3", 2, &["invalid value: \"1 mm\"", "a speed of rotation"]);
    refused("bearing[0].elements=2..9:8", 2, &["invalid value: 2, expected a whole number from 3 to 64"]);
    // A speed is usually in rpm, a play in um: a number without a unit has two likely readings.
    let two =
        "--over: no unit: \"shaft.speed=500..1000:3\", expected \"500rpm..1000rpm:3\" or \"500rad/s..1000rad/s:3\"";
    refused("shaft.speed=500..1000:3", 2, &[two]);
    refused("bearing.A.radial_play=3,10", 2, &["expected \"3um,10um\" or \"3mm,10mm\""]);
    refused("bearing[0].radial_play=0.01", 2, &["expected \"0.01mm\" or \"0.01m\""]);
    refused("shaft.speed=0,0", 1, &["shaft.speed: shaft at standstill, expected a rotating shaft"]);
    sandbox.refused(
        &["sweep", "scene.toml", "-o", "a", "--over", SPEEDS, "--shard", "4/3"],
        2,
        &["--shard: invalid part: \"4/3\", expected K/N"],
    );
}

/// A force is usually in newtons, a contact stiffness in N/m^n, a number of elements has no unit.
#[test]
fn numbers_without_a_unit_are_si_where_that_is_usual() {
    let sandbox = sandbox("tiwari-balanced");
    sweep(&sandbox, &["--over", "bearing.A.elements=8", "--over", "rotor.mass=0.5,0.6", "-o", "a"]);
    assert_eq!(column(&sandbox, "a.csv", "rotor.mass"), [Some(0.5), Some(0.6)]);
}

/// Without `--settle`, a transient that decays slower than the damping of the rotor is awaited: a balanced rotor has no subharmonics
/// where its Lyapunov exponent is far below 0.
#[test]
fn a_slow_transient_is_no_subharmonic() {
    let sandbox = sandbox("tiwari-balanced");
    let scene = swap(&sandbox.read("scene.toml"), "radial_play = \"3 um\"", "radial_play = \"1 um\"");
    sandbox.put("scene.toml", scene);
    let over = "shaft.speed=8000rpm,8200rpm,8400rpm,8600rpm";
    sandbox.done(&["sweep", "scene.toml", "--over", over, "--lyapunov", "-o", "a"]);
    let (periods, exponents) = (column(&sandbox, "a.csv", "period"), column(&sandbox, "a.csv", "lyapunov_per_s"));
    assert!(exponents.iter().all(|exponent| exponent.unwrap() < -10.0), "{exponents:?}");
    assert_eq!(periods, [Some(1.0); 4], "{exponents:?}");
}

/// The demonstration's scene without a recording, whose step of 1 ms is taken whole where the samples are farther apart: below 390 rpm.
fn coarse() -> Sandbox {
    let sandbox = Sandbox::empty();
    let (bare, _) = DEMO_SCENE.split_once("[recording]").unwrap();
    sandbox.put("scene.toml", bare.to_owned() + "[integration]\nstep = \"1 ms\"\n");
    sandbox
}

/// A point whose motion overflows has no results, and text, table and JSON name it; a sweep of such points only is an error.
#[test]
fn points_that_overflow_are_named() {
    let sandbox = coarse();
    let args = ["sweep", "scene.toml", "--settle", "0.1 s", "--periods", "16", "-o", "a"];
    let run = |over: &str, more: &[&str]| sandbox.done(&[&args[..], &["--over", over], more].concat());
    let mixed = "shaft.speed=200rpm,6000rpm";
    let text = run(mixed, &[]).out;
    assert!(text.contains("WARNING: the motion overflows at 1 of 2 points, which have no results:"), "{text}");
    assert!(
        text.contains("point 0 (shaft.speed = 200 rpm): the motion overflows: ") && text.contains("beyond"),
        "{text}"
    );
    for name in ["u_peak_to_peak_um", "v_mean_um", "u_one_x_um"] {
        let found = column(&sandbox, "a.csv", name);
        assert!(found[0].is_none() && found[1].is_some(), "{name}: {found:?}");
    }
    let table = sandbox.read("a.csv");
    assert!(table.lines().next().unwrap().ends_with(",overflow"), "{table}");
    let [first, second] = [1, 2].map(|line| table.lines().nth(line).unwrap());
    assert!(first.contains("the motion overflows: ") && !second.contains("overflows"), "{table}");
    assert!(sandbox.read("a.html").contains("overflows"));
    let summary: Value = run(mixed, &["--format", "json"]).json();
    let point = &summary["overflowed"][0];
    assert!(point["point"] == 0 && point["values"] == "shaft.speed = 200 rpm", "{summary}");
    // Both directions: the point after one that overflows starts from equilibrium.
    let summary: Value = run(mixed, &["--format", "json", "--follow", "both"]).json();
    assert_eq!(summary["overflowed"].as_array().map(Vec::len), Some(2), "{summary}");

    let all = coarse();
    let over = ["--over", "shaft.speed=100rpm,200rpm"];
    let said = "the motion overflows at every point of 2; shaft.speed = 100 rpm: the motion overflows: ";
    all.refused(&[&args[..], &over].concat(), 1, &[said]);
    assert_eq!(all.files(), ["scene.toml"]);
    for shard in ["1/2", "2/2"] {
        let out = all.done(&[&args[..], &over, &["--shard", shard]].concat()).out;
        assert!(out.contains("WARNING: the motion overflows at 1 of 1 points"), "{out}");
    }
    all.refused(&[&args[..], &over, &["--merge"]].concat(), 1, &[said]);
}
