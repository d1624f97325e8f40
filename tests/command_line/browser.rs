//! A headless browser, driven through its debugging pipe.

use crate::live_start::wait;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Duration;

/// A browser with one page.
pub struct Browser {
    child: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    session: Option<String>,
    sent: u64,
    /// Messages of the console and errors of the page.
    pub problems: Vec<String>,
    /// Addresses that were requested.
    pub requests: Vec<String>,
    _profile: tempfile::TempDir,
}

impl Browser {
    pub fn open(url: &str) -> Self {
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
        let mut browser =
            Self { child, to, from, session: None, sent: 0, problems: vec![], requests: vec![], _profile: profile };
        let target = browser.call("Target.createTarget", &json!({ "url": "about:blank" }));
        let attach = json!({ "targetId": target["targetId"], "flatten": true });
        let session = browser.call("Target.attachToTarget", &attach);
        browser.session = Some(session["sessionId"].as_str().unwrap().to_owned());
        for domain in ["Runtime.enable", "Log.enable", "Page.enable", "Network.enable"] {
            browser.call(domain, &json!({}));
        }
        browser.go(url);
        browser
    }

    /// Opens another address in the page.
    pub fn go(&mut self, url: &str) {
        self.call("Page.navigate", &json!({ "url": url }));
        self.wait_for("document.readyState === 'complete'");
    }

    pub fn call(&mut self, method: &str, params: &Value) -> Value {
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
                Some("Network.requestWillBeSent") => {
                    self.requests.push(answer["params"]["request"]["url"].as_str().unwrap().to_owned());
                }
                _ => {}
            }
            if answer["id"] == self.sent {
                assert!(answer["error"].is_null(), "{answer}");
                return answer["result"].take();
            }
        }
    }

    pub fn evaluate(&mut self, expression: &str) -> Value {
        let params = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        self.call("Runtime.evaluate", &params)["result"]["value"].take()
    }

    pub fn wait_for(&mut self, expression: &str) {
        wait(expression, || {
            std::thread::sleep(Duration::from_millis(100));
            (self.evaluate(expression) == true).then_some(())
        });
    }

    pub fn text(&mut self, id: &str) -> String {
        self.evaluate(&format!("document.getElementById('{id}').innerText")).as_str().unwrap().to_owned()
    }

    /// Sets the size of the window.
    pub fn resize(&mut self, width: u32, height: u32) {
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", &size);
    }

    /// Width of the page beyond that of a window of `width` pixels.
    pub fn overflow(&mut self, width: u32) -> f64 {
        self.resize(width, 900);
        self.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth").as_f64().unwrap()
    }
}

impl Browser {
    /// Moves the mouse along points of the window; the button is pressed at the first one and released at the last one.
    pub fn drag(&mut self, points: &[[f64; 2]], modifiers: u32) {
        let (Some(first), Some(last)) = (points.first(), points.last()) else { return };
        self.mouse("mouseMoved", *first, modifiers);
        self.mouse("mousePressed", *first, modifiers);
        points.iter().skip(1).for_each(|point| self.mouse("mouseMoved", *point, modifiers));
        self.mouse("mouseReleased", *last, modifiers);
    }

    /// Sends one event of the mouse.
    pub fn mouse(&mut self, kind: &str, [x, y]: [f64; 2], modifiers: u32) {
        let button = if kind == "mouseMoved" { "none" } else { "left" };
        let buttons = u8::from(kind != "mouseReleased");
        let event = json!({
            "type": kind, "x": x, "y": y, "button": button, "buttons": buttons, "clickCount": 1, "modifiers": modifiers,
        });
        self.call("Input.dispatchMouseEvent", &event);
    }

    /// Turns the wheel at a point of the window.
    pub fn wheel(&mut self, [x, y]: [f64; 2], delta: f64) {
        let event = json!({ "type": "mouseWheel", "x": x, "y": y, "deltaX": 0, "deltaY": delta });
        self.call("Input.dispatchMouseEvent", &event);
    }

    /// Presses a key.
    pub fn key(&mut self, key: &str) {
        let code = match key {
            "ArrowRight" => 39,
            "ArrowLeft" => 37,
            "Escape" => 27,
            _ => 0,
        };
        for kind in ["keyDown", "keyUp"] {
            let event = json!({ "type": kind, "key": key, "windowsVirtualKeyCode": code });
            self.call("Input.dispatchKeyEvent", &event);
        }
    }

    /// Moves two fingers from two points to two others.
    pub fn pinch(&mut self, from: [[f64; 2]; 2], to: [[f64; 2]; 2]) {
        let points = |points: [[f64; 2]; 2]| -> Vec<Value> {
            points.iter().enumerate().map(|(id, [x, y])| json!({ "x": x, "y": y, "id": id })).collect()
        };
        for (kind, points) in [("touchStart", points(from)), ("touchMove", points(to)), ("touchEnd", vec![])] {
            self.call("Input.dispatchTouchEvent", &json!({ "type": kind, "touchPoints": points }));
        }
    }

    /// Prints the page and returns the PDF.
    pub fn pdf(&mut self) -> Vec<u8> {
        let printed = self.call("Page.printToPDF", &json!({ "preferCSSPageSize": true, "printBackground": true }));
        decoded(printed["data"].as_str().unwrap())
    }
}

/// Bytes of a text in base64.
fn decoded(text: &str) -> Vec<u8> {
    let digit = |c: u8| match c {
        b'A'..=b'Z' => c - b'A',
        b'a'..=b'z' => c - b'a' + 26,
        b'0'..=b'9' => c - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let digits: Vec<u32> = text.bytes().filter(|c| *c != b'=').map(|c| u32::from(digit(c))).collect();
    let group = |group: &[u32]| {
        let word = group.iter().enumerate().fold(0, |word, (i, digit)| word | digit << (18 - 6 * i));
        (0..group.len() - 1).map(move |i| (word >> (16 - 8 * i)) as u8).collect::<Vec<_>>()
    };
    digits.chunks(4).flat_map(group).collect()
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
