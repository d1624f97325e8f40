//! The reports as a browser shows and prints them: every picture is there, no text covers another, nothing is cut, and the figures can
//! be zoomed, read and computed anew.

use std::path::Path;

use serde::Deserialize;
use serde_json::{Value, json};

use crate::browser::Browser;
use crate::support::{DEMO_SCENE, Sandbox, recorded};

/// Largest file that one sends by mail.
const MAX_BYTES: usize = 3_000_000;
/// Largest script of a report.
const MAX_SCRIPT: usize = 60_000;
/// Most pages of a printed report.
const MAX_PAGES: usize = 6;
/// A telephone's screen, a tablet's and a sandbox's.
const WIDTHS: [u32; 3] = [400, 800, 1400];
/// Largest loss of a peak between two bins under a Hann window: 1.42 dB.
const SCALLOPING: f64 = 0.16;

/// Result of `measure.js`.
#[derive(Debug, Deserialize)]
struct Measured {
    width: u32,
    titles: Vec<String>,
    faults: Vec<String>,
}

fn address(path: &Path) -> String {
    format!("file://{}", path.display())
}

/// Opens a report and checks it at each width and on paper; it has to have figures with the expected titles.
fn looks_right(browser: &mut Browser, path: &Path, expected: &[&str]) {
    let report = std::fs::read_to_string(path).unwrap();
    assert!(report.len() < MAX_BYTES, "{} bytes", report.len());
    let script = report.rsplit("<script>").next().and_then(|rest| rest.split("</script>").next()).unwrap();
    assert!(script.len() < MAX_SCRIPT, "{} bytes of script", script.len());
    // Without its script the page has every figure and table.
    let still = report.split("<script").next().unwrap();
    assert_eq!(still.matches("<figure").count(), still.matches("</svg>").count());
    browser.requests.clear();
    browser.go(&address(path));
    for width in WIDTHS {
        browser.resize(width, 900);
        let seen = browser.evaluate(include_str!("measure.js"));
        let seen: Measured = serde_json::from_str(seen.as_str().unwrap()).unwrap();
        assert_eq!(seen.width, width);
        assert!(seen.faults.is_empty(), "{} at {width}: {:#?}", path.display(), seen.faults);
        for title in expected {
            assert!(seen.titles.iter().any(|there| there.contains(title)), "no {title} among {:#?}", seen.titles);
        }
    }
    let pdf = browser.pdf();
    assert!(pdf.starts_with(b"%PDF"));
    let pages = String::from_utf8_lossy(&pdf).matches("/Type /Page\n").count();
    assert!((1..=MAX_PAGES).contains(&pages), "{pages} pages of {}", path.display());
    // On paper the rows of a long table run on over pages.
    browser.call("Emulation.setEmulatedMedia", &serde_json::json!({ "media": "print" }));
    let kept = "[...document.querySelectorAll('.table-section:not(.short)')].filter((t) => getComputedStyle(t).display !== 'block').length";
    assert_eq!(browser.evaluate(kept), 0);
    browser.call("Emulation.setEmulatedMedia", &serde_json::json!({ "media": "" }));
    let outside: Vec<&String> = browser.requests.iter().filter(|url| **url != address(path)).collect();
    assert!(outside.is_empty() && browser.requests.len() == 1, "{:?}", browser.requests);
    // Another script than the report's own does not run.
    browser.evaluate("(() => { const s = document.createElement('script'); s.textContent = 'window.foreign = 1'; document.body.append(s); })()");
    assert_eq!(browser.evaluate("window.foreign === undefined"), true);
    let unexpected: Vec<&String> =
        browser.problems.iter().filter(|text| !text.contains("Content Security Policy")).collect();
    assert!(unexpected.is_empty(), "{unexpected:#?}");
    browser.problems.clear();
}

/// Replays, and returns the outcome; the report is `report.html`.
fn replayed(sandbox: &Sandbox, args: &[&str]) -> Value {
    let args = [&["replay"], args, &["--report", "report.html", "--format", "json"]].concat();
    sandbox.done(&args).json()
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

/// A figure of the open report, found by its title.
struct Shown<'a> {
    browser: &'a mut Browser,
    title: &'a str,
}

impl Shown<'_> {
    /// Evaluates an expression of `figure` and `svg`.
    fn get(&mut self, expression: &str) -> Value {
        let find = format!(
            "[...document.querySelectorAll('figure')].find((f) => f.querySelector('figcaption').textContent.startsWith({}))",
            json!(self.title)
        );
        self.browser.evaluate(&format!(
            "(() => {{ const figure = {find}, svg = figure.querySelector('svg'); return {expression}; }})()"
        ))
    }

    /// Brings the figure to the middle of the window.
    fn scroll(&mut self) {
        self.get("figure.scrollIntoView({ block: 'center' })");
    }

    /// Edges of the frame number `n` in the window: left, top, right, bottom.
    fn frame(&mut self, n: usize) -> [f64; 4] {
        // The edge of a frame is a polyline of five points beside its axes.
        let edge = format!(
            "(() => {{ const box = svg.querySelector('[data-axes=\"{n}\"]').nextElementSibling.getBoundingClientRect(); \
             return [box.left, box.top, box.right, box.bottom]; }})()"
        );
        serde_json::from_value(self.get(&edge)).unwrap()
    }

    /// A point of a frame by its shares along X and Y.
    fn at(&mut self, n: usize, [x, y]: [f64; 2]) -> [f64; 2] {
        let [left, top, right, bottom] = self.frame(n);
        [left + x * (right - left), bottom - y * (bottom - top)]
    }

    /// Moves the mouse there.
    fn hover(&mut self, n: usize, share: [f64; 2]) {
        let point = self.at(n, share);
        self.browser.mouse("mouseMoved", point, 0);
    }

    /// Presses the button of a name.
    fn press(&mut self, label: &str) {
        self.get(&format!(
            "[...figure.querySelectorAll('button')].find((b) => b.textContent === {}).click()",
            json!(label)
        ));
    }

    /// Value of the readout by its name.
    fn reading(&mut self, name: &str) -> f64 {
        let values = self.get("figure.querySelector('output').dataset.values");
        let values: Vec<(String, Option<f64>, String)> = serde_json::from_str(values.as_str().unwrap()).unwrap();
        let found = values.iter().find(|value| value.0 == name);
        found.and_then(|value| value.1).unwrap_or_else(|| panic!("no {name} among {values:?}"))
    }

    /// First and last tick label below frame `n`.
    fn ends(&mut self, n: usize) -> [f64; 2] {
        let labels = self.get(&format!(
            "[...svg.querySelectorAll('[data-axes=\"{n}\"] text[text-anchor=middle]')].map((t) => Number(t.textContent.replace('−', '-')))"
        ));
        let labels: Vec<f64> = serde_json::from_value(labels).unwrap();
        [labels[0], labels[labels.len() - 1]]
    }

    /// Frequencies that frame 0 shows, nearly.
    fn span(&mut self) -> f64 {
        let [low, high] = [0.02, 0.98].map(|share| {
            self.hover(0, [share, 0.5]);
            self.reading("Frequency")
        });
        high - low
    }

    fn content(&mut self) -> String {
        self.get("[...svg.querySelectorAll('[data-axes], [data-curve], [data-inside], [data-along]')].map((g) => g.outerHTML).join('')")
            .as_str()
            .unwrap()
            .to_owned()
    }
}

/// The reading of the cursor where a spectrum has a line, against the outcome.
fn cursor_reads_the_spectrum(browser: &mut Browser, outcome: &Value) {
    let probe = &outcome["probes"][0];
    let name = format!("Spectrum of {}", probe["name"].as_str().unwrap());
    let speed_hz = outcome["record"]["mean_speed_rpm"].as_f64().unwrap() / 60.0;
    let bin_hz = outcome["record"]["spectra"]["bin_hz"].as_f64().unwrap();
    let mut figure = Shown { browser, title: &name };
    figure.scroll();
    // Frame 0 begins at 0 Hz; its end follows from one reading.
    figure.hover(0, [0.5, 0.5]);
    let end = 2.0 * figure.reading("Frequency");
    figure.hover(0, [speed_hz / end, 0.5]);
    // The keyboard moves the cursor by one line: the highest of three is that of 1X.
    figure.get("figure.querySelector('.plot').focus()");
    let mut best = [0.0_f64; 3];
    figure.browser.key("ArrowLeft");
    for _ in 0..3 {
        let hz = figure.reading("Frequency");
        assert!((hz / bin_hz - (hz / bin_hz).round()).abs() < 1e-3, "{hz} Hz is a line");
        assert!((figure.reading("order") - hz / speed_hz).abs() < 1e-6);
        let [measured, twin] = [figure.reading("measured"), figure.reading("twin")];
        if measured > best[0] {
            best = [measured, twin, figure.reading("residual")];
        }
        figure.browser.key("ArrowRight");
    }
    for (found, expected) in [(best[0], &probe["measured"]["one_x_um"]), (best[1], &probe["twin"]["one_x_um"])] {
        let expected = expected.as_f64().unwrap();
        assert!(found < 1.02 * expected && found > (1.0 - SCALLOPING) * expected, "{found} um, expected {expected} um");
    }
    assert!(
        best[2] < 2.0 * probe["one_x_error_um"].as_f64().unwrap() + probe["noise_um"].as_f64().unwrap_or(0.0),
        "{best:?}"
    );
    figure.browser.key("Escape");
}

/// A position in the trace, against the mean and the peak to peak of the outcome.
fn cursor_reads_the_trace(browser: &mut Browser, outcome: &Value) {
    let probe = &outcome["probes"][1];
    let name = format!("Position at {}", probe["name"].as_str().unwrap());
    let mut figure = Shown { browser, title: &name };
    figure.scroll();
    let [mean, peak_to_peak] = ["mean_um", "peak_to_peak_um"].map(|key| probe["measured"][key].as_f64().unwrap());
    let rate = outcome["record"]["rate_hz"].as_f64().unwrap();
    for share in [0.2, 0.45, 0.7] {
        figure.hover(0, [share, 0.5]);
        let samples = figure.reading("Time") * 1e-3 * rate;
        assert!((samples - samples.round()).abs() < 1e-3, "sample {samples}");
        let [measured, twin, residual] = ["measured", "twin", "Residual"].map(|name| figure.reading(name));
        assert!((measured - mean).abs() <= peak_to_peak, "{measured} um, mean {mean} um");
        assert!((measured - twin - residual).abs() < 1e-5 * measured.abs().max(1.0), "{measured} {twin} {residual}");
    }
}

/// Zoom by wheel, box, buttons, keys and two fingers; the view moves and comes back.
fn figures_zoom(browser: &mut Browser) {
    let mut figure = Shown { browser, title: "Spectrum of NDE_X_um" };
    figure.scroll();
    let still = figure.content();
    let [low, high] = figure.ends(0);
    let length = |ends: [f64; 2]| ends[1] - ends[0];
    // A box over half of the range.
    let [from, to] = [[0.2, 0.8], [0.7, 0.2]].map(|share| figure.at(0, share));
    let middle = [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])];
    figure.browser.drag(&[from, middle, to], 0);
    let boxed = figure.ends(0);
    assert!(boxed[0] > low && boxed[1] < high && length(boxed) < 0.5 * length([low, high]), "{boxed:?}");
    let zoomed = figure.content();
    assert!(zoomed != still && zoomed.contains("clip-path"));
    // Drag with shift moves the view to higher frequencies; its length stays.
    figure.browser.drag(&[to, middle], 8);
    let moved = figure.ends(0);
    assert!(moved[0] > boxed[0], "{boxed:?} {moved:?}");
    let before = figure.span();
    figure.browser.wheel(middle, -120.0);
    assert!(figure.span() < 0.9 * before, "{} Hz of {before} Hz", figure.span());
    figure.press("Reset");
    assert_eq!(figure.content(), still, "the still figure is back");
    figure.press("+");
    assert!(length(figure.ends(0)) < length([low, high]));
    figure.press("−");
    figure.browser.key("0");
    assert_eq!(figure.content(), still);
    // A spectrum can be moved beyond its still range.
    for _ in 0..8 {
        figure.press("−");
    }
    assert!(figure.ends(0)[1] > 2.0 * high, "{:?}", figure.ends(0));
    figure.press("Reset");
    let whole = figure.span();
    let fingers = [[0.45, 0.5], [0.55, 0.5]].map(|share| figure.at(0, share));
    let apart = [[0.3, 0.5], [0.7, 0.5]].map(|share| figure.at(0, share));
    figure.browser.pinch(fingers, apart);
    assert!(figure.span() < 0.5 * whole, "{} Hz of {whole} Hz", figure.span());
    figure.press("Reset");
    assert_eq!(figure.content(), still);
    // An orbit keeps equal scales.
    let mut orbit = Shown { browser, title: "Orbit of DE_X_um" };
    orbit.scroll();
    let [from, to] = [[0.3, 0.7], [0.6, 0.5]].map(|share| orbit.at(0, share));
    orbit.browser.drag(&[from, to], 0);
    orbit.hover(0, [0.5, 0.5]);
    assert!(orbit.reading("X").is_finite() && orbit.reading("Y").is_finite());
    orbit.press("Reset");
}

/// The harmonic and the side-band cursor follow the mouse and the keyboard.
fn harmonics_follow(browser: &mut Browser, outcome: &Value) {
    let speed_hz = outcome["record"]["mean_speed_rpm"].as_f64().unwrap() / 60.0;
    let mut figure = Shown { browser, title: "Spectrum of DE_X_um" };
    figure.scroll();
    figure.hover(0, [0.5, 0.5]);
    let end = 2.0 * figure.reading("Frequency");
    // The harmonics start at the cursor, or without one at the highest peak.
    figure.browser.mouse("mouseMoved", [2.0, 2.0], 0);
    figure.press("Harmonics");
    let found = figure.reading("Fundamental");
    assert!((found - speed_hz).abs() < 4.0, "the highest peak is 1X: {found} Hz");
    let measured = figure.reading("1");
    let expected = outcome["probes"][0]["measured"]["one_x_um"].as_f64().unwrap();
    assert!(
        measured > (1.0 - SCALLOPING) * expected && measured < 1.02 * expected,
        "{measured} um at 1, expected {expected}"
    );
    // The second multiple is dragged to three times the fundamental: the fundamental is 1.5 times as large.
    let [from, to] = [2.0, 3.0].map(|k| figure.at(0, [k * found / end, 0.4]));
    figure.browser.drag(&[from, to], 0);
    let dragged = figure.reading("Fundamental");
    assert!((dragged - 1.5 * found).abs() < 0.01 * end, "{found} Hz, then {dragged} Hz");
    assert!((figure.reading("order") - dragged / speed_hz).abs() < 1e-4);
    let places =
        figure.get("[...svg.querySelectorAll('.overlay line.multiple')].map((l) => Number(l.getAttribute('x1')))");
    let places: Vec<f64> = serde_json::from_value(places).unwrap();
    assert!(places.len() > 3);
    let spacings: Vec<f64> = places.windows(2).take(3).map(|pair| pair[1] - pair[0]).collect();
    assert!(spacings.iter().all(|d| (d - spacings[0]).abs() < 0.25), "{spacings:?}");
    figure.browser.key("ArrowRight");
    assert!(figure.reading("Fundamental") > dragged);
    figure.press("Harmonics");
    figure.press("Side bands");
    let (centre, spacing) = (figure.reading("Centre"), figure.reading("spacing"));
    assert!((spacing - speed_hz).abs() < 1e-6, "{spacing} Hz: that of the shaft");
    let [from, to] = [1.0, 2.0].map(|k| figure.at(0, [(centre + k * spacing) / end, 0.4]));
    figure.browser.drag(&[from, to], 0);
    assert!((figure.reading("spacing") - 2.0 * spacing).abs() < 0.01 * end && figure.reading("Centre") == centre);
    figure.browser.key("Escape");
    assert_eq!(figure.get("svg.querySelectorAll('.overlay line').length"), 0);
}

/// A click on a diagnosis marks its lines in every spectrum, and the figures and rows of its bearing.
fn a_diagnosis_is_highlighted(browser: &mut Browser, outcome: &Value) {
    assert!(!outcome["findings"].as_array().unwrap().is_empty());
    assert_eq!(browser.evaluate("document.querySelectorAll('.highlights line').length"), 0);
    browser.evaluate("document.querySelector('tr[data-diagnosis] button').click()");
    let every = "[...document.querySelectorAll('figure')].filter((f) => /pectrum|Waterfall|Unexplained/.test(f.querySelector('figcaption').textContent)) \
                 .map((f) => f.querySelectorAll('.highlights line').length)";
    let counts: Vec<u64> = serde_json::from_value(browser.evaluate(every)).unwrap();
    assert!(counts.len() > 8 && counts.iter().all(|count| *count > 1), "{counts:?}");
    let of_bearing = browser.evaluate("document.querySelectorAll('figure.highlighted').length").as_u64().unwrap();
    assert!(of_bearing >= 2, "{of_bearing}");
    browser.evaluate("document.querySelector('tr[data-diagnosis] button').click()");
    assert_eq!(browser.evaluate("document.querySelectorAll('.highlights line, .highlighted').length"), 0);
}

/// Orbits and spectra of a chosen time agree with the outcome, and the still figures come back.
fn a_time_range_is_computed(browser: &mut Browser, outcome: &Value) {
    let speed_hz = outcome["record"]["mean_speed_rpm"].as_f64().unwrap() / 60.0;
    let still = Shown { browser, title: "Orbit of NDE_X_um" }.content();
    let choose = |browser: &mut Browser, start: f64, length: f64| {
        browser.evaluate(&format!(
            "(() => {{ const [start, length] = document.querySelectorAll('.range input[type=number]'); \
             start.value = {start}; length.value = {length}; length.dispatchEvent(new Event('change')); }})()"
        ));
        browser.wait_for(&format!(
            "JSON.parse(document.querySelector('.range output').dataset.window || '[0]')[0].toFixed(3) === '{start:.3}'"
        ));
        let window = browser.evaluate("document.querySelector('.range output').dataset.window");
        serde_json::from_str::<[f64; 3]>(window.as_str().unwrap()).unwrap()
    };
    let [start, end, samples] = choose(browser, 0.3, 0.4);
    assert!((start - 0.3).abs() < 1e-3 && (end - 0.7).abs() < 1e-3 && samples > 4000.0, "{start} {end} {samples}");
    let mut orbit = Shown { browser, title: "Orbit of NDE_X_um" };
    assert_ne!(orbit.content(), still);
    let path = "[...svg.querySelectorAll('[data-curve=\"0.0\"] polyline')].map((l) => l.getAttribute('points').length).reduce((a, b) => a + b, 0)";
    let long = orbit.get(path).as_f64().unwrap();
    choose(browser, 0.3, 0.1);
    let short = Shown { browser, title: "Orbit of NDE_X_um" }.get(path).as_f64().unwrap();
    assert!(short < 0.5 * long, "{short} of {long}: a quarter of the time");
    choose(browser, 0.3, 0.4);
    // The spectrum of the range: resolution by its length, the amplitude of 1X as in the outcome.
    let mut figure = Shown { browser, title: "Spectrum of DE_X_um" };
    figure.scroll();
    figure.hover(0, [0.5, 0.5]);
    let end = 2.0 * figure.reading("Frequency");
    let mut best = [0.0_f64; 2];
    figure.hover(0, [speed_hz / end, 0.5]);
    figure.get("figure.querySelector('.plot').focus()");
    figure.browser.key("ArrowLeft");
    for _ in 0..3 {
        let [measured, twin] = [figure.reading("measured"), figure.reading("twin")];
        if measured > best[0] {
            best = [measured, twin];
        }
        figure.browser.key("ArrowRight");
    }
    figure.browser.key("Escape");
    for (found, key) in best.into_iter().zip(["measured", "twin"]) {
        let expected = outcome["probes"][0][key]["one_x_um"].as_f64().unwrap();
        assert!(
            found < 1.03 * expected && found > (1.0 - SCALLOPING - 0.01) * expected,
            "{key}: {found} um, {expected} um"
        );
    }
    let mut trace = Shown { browser, title: "Position at DE_X_um" };
    trace.scroll();
    trace.hover(0, [0.5, 0.5]);
    let time = trace.reading("Time");
    assert!((time - 500.0).abs() < 10.0, "{time} ms is the middle of the range");
    browser.evaluate("document.querySelector('.range button').click()");
    assert_eq!(Shown { browser, title: "Orbit of NDE_X_um" }.content(), still);
}

/// Dark and light have paper and ink of their own.
fn has_a_dark_style(browser: &mut Browser) {
    let mut paper_and_ink = |scheme: &str| {
        let features = json!({ "features": [{ "name": "prefers-color-scheme", "value": scheme }] });
        browser.call("Emulation.setEmulatedMedia", &features);
        let colours = browser.evaluate(
            "[getComputedStyle(document.documentElement).backgroundColor, getComputedStyle(document.documentElement).color, \
             getComputedStyle(document.querySelector('[data-curve]')).stroke].map((c) => c.match(/\\d+/g).slice(0, 3) \
             .reduce((sum, x) => sum + Number(x), 0))",
        );
        serde_json::from_value::<[f64; 3]>(colours).unwrap()
    };
    let ([light, ink, line], [dark, light_ink, light_line]) = (paper_and_ink("light"), paper_and_ink("dark"));
    assert!(light - ink > 500.0 && light - line > 150.0, "{light} {ink} {line}");
    assert!(light_ink - dark > 500.0 && light_line - dark > 150.0, "{dark} {light_ink} {light_line}");
    paper_and_ink("light");
}

#[test]
#[ignore = "needs chromium; tests/run runs it"]
fn demonstration_in_a_browser() {
    let sandbox = Sandbox::empty();
    let outcome = replayed(&sandbox, &[]);
    let path = sandbox.path("report.html");
    let mut browser = Browser::open("about:blank");
    let expected = [&OF_PROBES[..], &["Waterfall of DE_X_um / DE_Y_um over time"]].concat();
    looks_right(&mut browser, &path, &expected);
    browser.resize(1400, 1000);
    let verdict =
        browser.evaluate("[...document.querySelectorAll('.verdict.red p')].map((p) => p.textContent).join(' ')");
    assert!(verdict.as_str().unwrap().starts_with("FAULT FOUND"), "{verdict}");
    assert!(verdict.as_str().unwrap().contains(outcome["verdict"].as_str().unwrap()), "{verdict}");
    // The first figure proves the verdict; tables follow the figures.
    let first = browser.evaluate("document.querySelector('figure figcaption').textContent");
    assert!(first.as_str().unwrap().starts_with("Bearing DE: Spall on the outer race"), "{first}");
    let links = browser.evaluate(
        "[...document.querySelectorAll('.contents a')].every((a) => document.querySelector(a.getAttribute('href')))",
    );
    assert_eq!(links, true);
    cursor_reads_the_spectrum(&mut browser, &outcome);
    cursor_reads_the_trace(&mut browser, &outcome);
    figures_zoom(&mut browser);
    harmonics_follow(&mut browser, &outcome);
    a_diagnosis_is_highlighted(&mut browser, &outcome);
    a_time_range_is_computed(&mut browser, &outcome);
    has_a_dark_style(&mut browser);
    assert_eq!(browser.problems, [""; 0]);
}

#[test]
#[ignore = "needs chromium; tests/run runs it"]
fn run_up_and_vibration_in_a_browser() {
    let mut browser = Browser::open("about:blank");
    let sandbox = Sandbox::empty();
    // A limit that is not reached, drawn in the trends.
    let limit = "\n[[limit]]\nindicator = \"peak-to-peak\"\nmax = \"2 um\"\n";
    sandbox.put("scene.toml", std::fs::read_to_string(recorded("run-up.toml")).unwrap() + limit);
    let over_speed = ["Bode plot of DE_X_um", "Polar plot of NDE_Y_um", "Cascade of NDE_X_um / NDE_Y_um over speed"];
    replayed(&sandbox, &["scene.toml", "--recording", &recorded("run-up.csv")]);
    looks_right(&mut browser, &sandbox.path("report.html"), &[&OF_PROBES[..], &over_speed].concat());
    let file = recorded("real/support_force_306rpm_6400Hz.csv");
    let scene = crate::vibration::scene(306.0, [7.0, 2.770, 10.514], &file, "6400 Hz", "force_N", "N");
    sandbox.put("scene.toml", scene);
    replayed(&sandbox, &["scene.toml"]);
    looks_right(&mut browser, &sandbox.path("report.html"), &["Envelope spectrum of force_N"]);
}

#[test]
#[ignore = "needs chromium; tests/run runs it"]
fn other_reports_in_a_browser() {
    let mut browser = Browser::open("about:blank");
    let sandbox = Sandbox::with(DEMO_SCENE, crate::support::HEALTHY_RECORDING);
    let report = ["--report", "report.html"];
    let cases: [(&[&str], &[&str]); 4] = [
        (&["equilibrium", "scene.toml"], &["Bearing DE: load on each element", "Rotor with bearings"]),
        (&["campbell", "scene.toml"], &["Campbell diagram"]),
        (&["fit", "scene.toml", "--turns", "8", "--only", "unbalance"], &["Residual at each probe"]),
        (&["trade", "scene.toml", "--forces-only"], &["Forces on a Cortex-M4F", "Forces on this machine"]),
    ];
    for (args, expected) in cases {
        sandbox.done(&[args, &report].concat());
        looks_right(&mut browser, &sandbox.path("report.html"), expected);
    }
    sandbox.done(&[
        "sweep",
        "scene.toml",
        "--over",
        "shaft.speed=1000rpm..3000rpm:3",
        "--periods",
        "16",
        "--output",
        "sweep",
    ]);
    looks_right(
        &mut browser,
        &sandbox.path("sweep.html"),
        &["Response", "Bifurcation diagram", "Waterfall of the motion"],
    );
    // A critical speed is in table and diagram.
    sandbox.done(&["campbell", "scene.toml", "--speeds", "0rpm..60000rpm:13", "--report", "report.html"]);
    browser.go(&address(&sandbox.path("report.html")));
    let named = browser.evaluate(
        "[...document.querySelectorAll('svg text')].map((t) => t.textContent).filter((t) => /^N\\d+$/.test(t)).length",
    );
    assert!(named.as_u64().unwrap() >= 3, "{named}");
    let connected = browser.evaluate("document.querySelectorAll('[data-curve] polyline').length").as_u64().unwrap();
    assert!(connected >= 3, "{connected}");
    let critical = browser.evaluate("document.querySelectorAll('#s2 tbody tr').length").as_u64().unwrap();
    assert!(critical >= 1, "{critical}");
}
