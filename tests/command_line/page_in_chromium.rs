//! The live page in a headless browser.

use crate::browser::Browser;
use crate::live::{connected, endless, rows};
use crate::page::{Site, hostile_scene};
use crate::support::{Sandbox, short_recording};
use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

#[test]
#[ignore = "needs chromium; tests/run runs it"]
fn an_alarm_is_shown_and_acknowledged_in_a_browser() {
    let site = Site::demonstration(&["--http-token-file", "token"]);
    let mut browser = Browser::open(&format!("http://127.0.0.1:{}/", site.port));
    has_word(&mut browser, "ALARM");
    assert!(browser.text("sentence").contains("Outer race of DE"), "{}", browser.text("sentence"));
    assert!(browser.text("action").contains("spare bearing") && browser.text("since").starts_with("since "));
    assert!(browser.text("since").contains(" UTC ("), "{}", browser.text("since"));
    browser.wait_for("document.querySelectorAll('#figures svg').length > 5");
    browser.wait_for("document.querySelectorAll('#history svg').length === 5");
    // The figures change with the samples.
    browser.evaluate("window.before = document.querySelector('#figures svg').outerHTML");
    browser.wait_for("document.querySelector('#figures svg').outerHTML !== window.before");
    let click = |token: &str| {
        format!(
            "document.getElementById('token').value = '{token}'; document.querySelector('#alarm-list button').click()"
        )
    };
    browser.evaluate(&click("a-wrong-token"));
    browser.wait_for("document.getElementById('answer').textContent.includes('wrong or missing token')");
    assert_eq!(browser.text("word"), "ALARM");
    browser.evaluate(&click("correct-horse-battery"));
    has_word(&mut browser, "ALARM, ACKNOWLEDGED");
    browser.wait_for("document.querySelector('#alarm-list button') === null");
    for width in [320, 400, 800, 1400] {
        assert!(browser.overflow(width) <= 0.0, "wider than {width} pixels");
    }
    // On a telephone all columns of the values and the whole sentence are seen.
    browser.resize(400, 900);
    for cut in [
        "document.querySelector('.scroll').scrollWidth - document.querySelector('.scroll').clientWidth",
        "document.getElementById('sentence').scrollHeight - document.getElementById('sentence').clientHeight",
    ] {
        assert!(browser.evaluate(cut).as_f64().unwrap() <= 0.0, "{cut}");
    }
    // The refusal of the wrong token is the only error that the browser has seen.
    let unexpected: Vec<&String> = browser.problems.iter().filter(|problem| !problem.contains("403")).collect();
    assert!(unexpected.is_empty(), "{unexpected:#?}");
    drop(site);
    has_word(&mut browser, "NO CONNECTION");
}

#[test]
#[ignore = "needs chromium; tests/run runs it"]
fn markup_in_names_is_text_in_a_browser() {
    let sandbox = Sandbox::with(&hostile_scene(), &short_recording(12_800));
    let source = crate::live::port();
    let site = Site::start(sandbox, &["scene.toml", "--source", &format!("tcp:{source}"), "--encoding", "frames"]);
    let mut browser = Browser::open(&format!("http://127.0.0.1:{}/", site.port));
    has_word(&mut browser, "NO DATA");
    let rows = rows(12_800);
    let frame_of = endless(&rows);
    let mut stream = connected(source);
    (0..64_000).for_each(|sequence| stream.write_all(&frame_of(sequence)).unwrap());
    browser.wait_for("document.getElementById('sentence').textContent.includes('peak-to-peak at DE_X_um')");
    assert_eq!(browser.evaluate("document.querySelectorAll('#value-rows tr.exceeded').length"), 1);
    assert!(browser.text("machine").contains("<b>rig</b><script>"), "{}", browser.text("machine"));
    browser.wait_for("document.querySelectorAll('#figures svg').length > 5");
    browser.wait_for("document.getElementById('figures').textContent.includes('<b>')");
    assert_eq!(
        browser.evaluate("document.querySelectorAll('b script, p b, svg b, nav b, script:not([src])').length"),
        0
    );
    assert_eq!(browser.problems, [""; 0]);
}

#[test]
#[ignore = "needs chromium; tests/run runs it"]
fn two_machines_are_shown_on_one_page_in_a_browser() {
    let ports = [crate::live::port(), crate::live::port()];
    let origins = ports.map(|port| format!("http://127.0.0.1:{port}"));
    let address = ports.map(|port| format!("127.0.0.1:{port}"));
    let start = |i: usize, more: &[&str]| {
        let args = [&["replay", "--paced", "--source", "demonstration", "--http", &address[i]], more].concat();
        let sandbox = Sandbox::empty();
        let child = sandbox.command(&args).spawn().unwrap();
        drop(connected(ports[i]));
        (sandbox, child)
    };
    let (_desk, mut first) = start(0, &["--http-also", &origins[1]]);
    let (_other_desk, mut second) = start(1, &["--http-origin", &origins[0]]);
    let mut browser = Browser::open(&origins[0]);
    browser.wait_for("document.querySelectorAll('#others .alarm').length === 1");
    assert!(browser.text("others").contains("6205 rig"), "{}", browser.text("others"));
    second.kill().unwrap();
    second.wait().unwrap();
    browser.wait_for("document.querySelectorAll('#others .lost').length === 1");
    has_word(&mut browser, "ALARM");
    first.kill().unwrap();
    first.wait().unwrap();
}

/// A network path that is lost leaves the page's connection open in silence; a new one works.
#[test]
#[ignore = "needs chromium; tests/run runs it"]
fn a_page_whose_connection_goes_silent_connects_again() {
    let site = Site::demonstration(&[]);
    let relay = Relay::start(site.port);
    let mut browser = Browser::open(&format!("http://127.0.0.1:{}/", relay.port));
    browser.wait_for("latest !== null && lostSince === null");
    for _ in 0..2 {
        relay.silence();
        let before = browser.evaluate("latest.time_s").as_f64().unwrap();
        browser.wait_for("lostSince !== null");
        browser.wait_for(&format!("lostSince === null && latest.time_s > {before} + 2"));
    }
    // Figures are loaded again too.
    browser.evaluate("window.before = document.getElementById('figures').innerHTML");
    browser.wait_for("document.getElementById('figures').innerHTML !== window.before");
}

/// Passes connections on, until all that exist become silent without an end.
struct Relay {
    port: u16,
    generation: Arc<AtomicU64>,
}

impl Relay {
    fn start(to: u16) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let generation = Arc::new(AtomicU64::new(0));
        let current = generation.clone();
        std::thread::spawn(move || {
            for client in listener.incoming().map_while(Result::ok) {
                let server = connected(to);
                let own = current.load(Ordering::SeqCst);
                for (mut from, mut to) in [(client.try_clone().unwrap(), server.try_clone().unwrap()), (server, client)]
                {
                    let current = current.clone();
                    std::thread::spawn(move || {
                        let mut buffer = [0; 4096];
                        while let Ok(count) = from.read(&mut buffer) {
                            while current.load(Ordering::SeqCst) != own {
                                std::thread::sleep(Duration::from_secs(1));
                            }
                            if count == 0 || to.write_all(&buffer[..count]).is_err() {
                                break;
                            }
                        }
                        let _ = to.shutdown(Shutdown::Both);
                    });
                }
            }
        });
        Self { port, generation }
    }

    fn silence(&self) {
        self.generation.fetch_add(1, Ordering::SeqCst);
    }
}

fn has_word(browser: &mut Browser, word: &str) {
    browser.wait_for(&format!("document.getElementById('word').textContent === '{word}'"));
}
