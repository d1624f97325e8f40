//! The report as a browser shows and prints it: every picture is there, no text covers another, no page is too wide.

use std::path::Path;
use std::process::Command;

use serde::Deserialize;
use serde_json::Value;

use crate::support::{Desk, recorded};

/// Largest file that one sends by mail.
const MAX_BYTES: usize = 3_000_000;
/// A desk's screen and a telephone's.
const WIDTHS: [u32; 2] = [1280, 400];

/// Measurements of a page by `measure.html`.
#[derive(Debug, Deserialize)]
struct SampleReadings {
    width: u32,
    titles: Vec<String>,
    faults: Vec<String>,
}

fn chromium(desk: &Desk, args: &[&str]) -> String {
    let profile = tempfile::tempdir().unwrap();
    let output = Command::new("chromium")
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .args(args)
        .current_dir(desk.path(""))
        .output()
        .expect("chromium; type: apt-get install -y --no-install-recommends chromium");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn address(path: &Path) -> String {
    format!("file://{}", path.display())
}

/// The page in a frame of each width: a browser's own window has a least width.
fn seen(desk: &Desk, report: &str) -> Vec<SampleReadings> {
    desk.put("measured.html", report.to_owned() + include_str!("measure.html"));
    let frames =
        WIDTHS.map(|w| format!("<iframe src=measured.html style='width:{w}px;height:900px;border:0'></iframe>"));
    let listen = "<script>onmessage = (e) => { const said = document.createElement('pre'); said.textContent = e.data; \
                  document.body.append(said); };</script>";
    desk.put("around.html", format!("<!DOCTYPE html><body>{listen}{}</body>", frames.concat()));
    let around = address(&desk.path("around.html"));
    let dom = chromium(desk, &["--dump-dom", "--virtual-time-budget=5000", "--window-size=1400,900", &around]);
    let said = dom.split("<pre>").skip(1).filter_map(|rest| rest.split("</pre>").next());
    let plain = |text: &str| text.replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    said.map(|text| serde_json::from_str(&plain(text)).unwrap()).collect()
}

/// Replays, looks at the report on both screens, and prints it.
fn looks_right(desk: &Desk, args: &[&str], expected: &[&str]) {
    let args = [&["replay"], args, &["--report", "report.html", "--format", "json"]].concat();
    let outcome: Value = desk.done(&args).json();
    let verdict = outcome["verdict"].as_str().unwrap();
    let report = desk.read("report.html");
    assert!(report.len() < MAX_BYTES, "{} bytes", report.len());
    let seen = seen(desk, &report);
    let mut widths: Vec<u32> = seen.iter().map(|one| one.width).collect();
    widths.sort_unstable_by(|a, b| b.cmp(a));
    assert_eq!(widths, WIDTHS, "{seen:?}");
    for one in &seen {
        assert!(one.faults.is_empty(), "at {}: {:#?}", one.width, one.faults);
        for title in expected {
            assert!(one.titles.iter().any(|there| there.contains(title)), "no {title} among {:#?}", one.titles);
        }
    }
    prints(desk, verdict);
}

/// On paper there are a few pages, and the verdict is on the first one, where the text can be read back.
fn prints(desk: &Desk, verdict: &str) {
    let to = format!("--print-to-pdf={}", desk.path("report.pdf").display());
    chromium(desk, &[&to, "--no-pdf-header-footer", &address(&desk.path("report.html"))]);
    assert!(std::fs::read(desk.path("report.pdf")).unwrap().starts_with(b"%PDF"));
    let Ok(text) = Command::new("pdftotext").arg(desk.path("report.pdf")).arg("-").output() else {
        println!("no pdftotext here: the print is not read back");
        return;
    };
    let text = String::from_utf8_lossy(&text.stdout).replace('\u{fb01}', "fi").replace('\u{fb02}', "fl");
    let pages: Vec<&str> = text.split_terminator('\u{c}').collect();
    assert!((1..30).contains(&pages.len()), "{} pages", pages.len());
    let first = pages[0].split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(first.contains(verdict), "{verdict:?} is not in {first:?}");
}

const OF_PROBES: [&str; 9] = [
    "Orbit of DE_X_um / DE_Y_um",
    "1X orbit at",
    "Shaft centreline at NDE_X_um / NDE_Y_um",
    "Position at axial_um over time",
    "Trend of DE_Y_um",
    "Spectrum of NDE_X_um",
    "Full spectrum of DE_X_um / DE_Y_um",
    "Force on the inner ring of bearing DE",
    "Load on the elements of bearing NDE",
];

#[test]
#[ignore = "needs chromium; tests/run runs it"]
fn demonstration_in_a_browser() {
    looks_right(&Desk::empty(), &[], &[&OF_PROBES[..], &["Waterfall of DE_X_um / DE_Y_um over time"]].concat());
}

#[test]
#[ignore = "needs chromium; tests/run runs it"]
fn run_up_with_limits_in_a_browser() {
    let desk = Desk::empty();
    // One that is not reached, drawn in the trends.
    let limit = "\n[[limit]]\nindicator = \"peak-to-peak\"\nmax = \"2 um\"\n";
    desk.put("scene.toml", std::fs::read_to_string(recorded("run-up.toml")).unwrap() + limit);
    let over_speed = ["Bode plot of DE_X_um", "Polar plot of NDE_Y_um", "Cascade of NDE_X_um / NDE_Y_um over speed"];
    let recording = recorded("run-up.csv");
    looks_right(&desk, &["scene.toml", "--recording", &recording], &[&OF_PROBES[..], &over_speed].concat());
}

#[test]
#[ignore = "needs chromium; tests/run runs it"]
fn damage_in_a_browser() {
    let desk = Desk::empty();
    let damaged = recorded("outer-spall.csv");
    looks_right(&desk, &[&recorded("healthy.toml"), "--recording", &damaged], &OF_PROBES);
}

#[test]
#[ignore = "needs chromium; tests/run runs it"]
fn vibration_in_a_browser() {
    let desk = Desk::empty();
    let file = recorded("real/support_force_306rpm_6400Hz.csv");
    let scene = crate::vibration::scene(306.0, [7.0, 2.770, 10.514], &file, "6400 Hz", "force_N", "N");
    desk.put("scene.toml", scene);
    looks_right(&desk, &["scene.toml"], &["Envelope spectrum of force_N"]);
}
