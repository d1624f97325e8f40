//! The live page in a headless browser, which is driven through its debugging pipe.

use crate::live::{connected, endless, rows};
use crate::live_start::wait;
use crate::page::{Site, hostile_scene};
use crate::support::{Desk, short_recording};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Duration;

/// A browser with one page.
struct Browser {
    child: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    session: Option<String>,
    sent: u64,
    /// Messages of the console and errors of the page.
    problems: Vec<String>,
    _profile: tempfile::TempDir,
}

impl Browser {
    fn open(url: &str) -> Self {
        let profile = tempfile::tempdir().unwrap();
        let options = "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking \
                       --disable-component-update --disable-sync --remote-debugging-pipe";
        // The browser reads commands from descriptor 3 and answers on 4.
        let script = format!("exec chromium {options} --user-data-dir=\"$0\" 3<&0 4>&1 </dev/null >/dev/null 2>&1");
        let mut child = Command::new("sh")
            .args(["-c", &script])
            .arg(profile.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (to, from) = (child.stdin.take().unwrap(), BufReader::new(child.stdout.take().unwrap()));
        let mut browser = Self { child, to, from, session: None, sent: 0, problems: vec![], _profile: profile };
        let target = browser.call("Target.createTarget", &json!({ "url": "about:blank" }));
        let attach = json!({ "targetId": target["targetId"], "flatten": true });
        let session = browser.call("Target.attachToTarget", &attach);
        browser.session = Some(session["sessionId"].as_str().unwrap().to_owned());
        for domain in ["Runtime.enable", "Log.enable", "Page.enable"] {
            browser.call(domain, &json!({}));
        }
        browser.call("Page.navigate", &json!({ "url": url }));
        browser
    }

    fn call(&mut self, method: &str, params: &Value) -> Value {
        self.sent += 1;
        let mut message = json!({ "id": self.sent, "method": method, "params": params });
        if let Some(session) = &self.session {
            message["sessionId"] = session.as_str().into();
        }
        self.to.write_all(format!("{message}\0").as_bytes()).unwrap();
        loop {
            let mut bytes = vec![];
            self.from.read_until(0, &mut bytes).unwrap();
            assert_eq!(
                bytes.pop(),
                Some(0),
                "chromium ended; type: apt-get install -y --no-install-recommends chromium"
            );
            let mut answer: Value = serde_json::from_slice(&bytes).unwrap();
            match answer["method"].as_str() {
                Some("Runtime.exceptionThrown") => self.problems.push(answer["params"].to_string()),
                Some("Log.entryAdded") if answer["params"]["entry"]["level"] == "error" => {
                    self.problems.push(answer["params"]["entry"]["text"].to_string());
                }
                _ => {}
            }
            if answer["id"] == self.sent {
                assert!(answer["error"].is_null(), "{answer}");
                return answer["result"].take();
            }
        }
    }

    fn evaluate(&mut self, expression: &str) -> Value {
        let params = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        self.call("Runtime.evaluate", &params)["result"]["value"].take()
    }

    fn wait_for(&mut self, expression: &str) {
        wait(expression, || {
            std::thread::sleep(Duration::from_millis(100));
            (self.evaluate(expression) == true).then_some(())
        });
    }

    fn text(&mut self, id: &str) -> String {
        self.evaluate(&format!("document.getElementById('{id}').innerText")).as_str().unwrap().to_owned()
    }

    fn has_word(&mut self, word: &str) {
        self.wait_for(&format!("document.getElementById('word').textContent === '{word}'"));
    }

    /// Width of the page beyond that of a window of `width` pixels.
    fn overflow(&mut self, width: u32) -> f64 {
        let size = json!({ "width": width, "height": 900, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", &size);
        self.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth").as_f64().unwrap()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
#[ignore = "needs chromium; tests/run runs it"]
fn an_alarm_is_shown_and_acknowledged_in_a_browser() {
    let site = Site::demonstration(&["--http-token-file", "token"]);
    let mut browser = Browser::open(&format!("http://127.0.0.1:{}/", site.port));
    browser.has_word("ALARM");
    assert!(browser.text("sentence").contains("Outer race of DE"), "{}", browser.text("sentence"));
    assert!(browser.text("action").contains("spare bearing") && browser.text("since").starts_with("since "));
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
    browser.has_word("ALARM, ACKNOWLEDGED");
    browser.wait_for("document.querySelector('#alarm-list button') === null");
    for width in [320, 400, 800, 1400] {
        assert!(browser.overflow(width) <= 0.0, "wider than {width} pixels");
    }
    // The refusal of the wrong token is the only error that the browser has seen.
    let unexpected: Vec<&String> = browser.problems.iter().filter(|problem| !problem.contains("403")).collect();
    assert!(unexpected.is_empty(), "{unexpected:#?}");
    drop(site);
    browser.has_word("NO CONNECTION");
}

#[test]
#[ignore = "needs chromium; tests/run runs it"]
fn markup_in_names_is_text_in_a_browser() {
    let desk = Desk::with(&hostile_scene(), &short_recording(12_800));
    let source = crate::live::port();
    let site = Site::start(desk, &["scene.toml", "--source", &format!("tcp:{source}"), "--encoding", "frames"]);
    let mut browser = Browser::open(&format!("http://127.0.0.1:{}/", site.port));
    browser.has_word("NO DATA");
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
        let desk = Desk::empty();
        let child = desk.command(&args).spawn().unwrap();
        drop(connected(ports[i]));
        (desk, child)
    };
    let (_desk, mut first) = start(0, &["--http-also", &origins[1]]);
    let (_other_desk, mut second) = start(1, &["--http-origin", &origins[0]]);
    let mut browser = Browser::open(&origins[0]);
    browser.wait_for("document.querySelectorAll('#others .alarm').length === 1");
    assert!(browser.text("others").contains("6205 rig"), "{}", browser.text("others"));
    second.kill().unwrap();
    second.wait().unwrap();
    browser.wait_for("document.querySelectorAll('#others .lost').length === 1");
    browser.has_word("ALARM");
    first.kill().unwrap();
    first.wait().unwrap();
}
