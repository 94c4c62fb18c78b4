//! A run that is made again when its files change, seen through its port.

use crate::bench::{Bench, CIRCLE};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Stdio};
use std::time::Duration;

/// Ends a program that would go on for ever, whatever the test finds.
struct Ended(Child);

impl Drop for Ended {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// What a request is answered with; nothing where the connection is closed without an answer.
fn ask(address: &str, head: &str) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    stream.write_all(head.as_bytes()).unwrap();
    let mut text = Vec::new();
    let _ = stream.read_to_end(&mut text);
    String::from_utf8_lossy(&text).into_owned()
}

fn get(address: &str, path: &str) -> String {
    ask(
        address,
        &format!("GET {path} HTTP/1.1\r\nHost: {address}\r\n\r\n"),
    )
}

/// The page, as soon as it has a text.
fn page_with(address: &str, text: &str) -> String {
    loop {
        let page = get(address, "/");
        if page.contains(text) {
            return page;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn a_page_follows_its_files_and_is_for_this_computer_alone() {
    let bench = Bench::new();
    bench.file("circle.ngc", CIRCLE);
    let mut command =
        bench.command(&["watch", "circle.ngc", "-m", "vmc3", "--tolerance-um", "999"]);
    command.stderr(Stdio::piped()).stdout(Stdio::null());
    let mut run = Ended(command.spawn().unwrap());
    let mut stderr = BufReader::new(run.0.stderr.take().unwrap());
    let mut said = String::new();
    stderr.read_line(&mut said).unwrap();
    let address = said.split("http://").nth(1).unwrap();
    let address = address.split('/').next().unwrap().to_owned();
    assert!(address.starts_with("127.0.0.1:"), "{said}");

    let page = page_with(&address, "within tolerance");
    assert!(page.starts_with("HTTP/1.1 200 OK\r\n") && page.contains("no-store"));
    // It may ask its own server, and nobody else.
    assert!(page.contains("default-src 'none'; connect-src 'self';"));
    let version = get(&address, "/version");
    // Another program of the same name, then one that is refused, then a good one again.
    bench.file(
        "circle.ngc",
        CIRCLE.replace("X10 Y0 I-10", "X10.5 Y0.5 I-10"),
    );
    page_with(&address, "arc-radii");
    assert_ne!(get(&address, "/version"), version);
    bench.file("circle.ngc", CIRCLE.replace("10", "12"));
    page_with(&address, "G3 X12 Y0 I-12 J0");
    // What no browser of this computer would ask.
    let elsewhere = "GET / HTTP/1.1\r\nHost: example.org\r\n\r\n";
    assert!(ask(&address, elsewhere).starts_with("HTTP/1.1 403 "));
    assert!(ask(&address, "GET / HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 403 "));
    assert!(get(&address, "/../secret").starts_with("HTTP/1.1 404 "));
    let post = format!("POST / HTTP/1.1\r\nHost: {address}\r\n\r\n");
    assert!(ask(&address, &post).starts_with("HTTP/1.1 405 "));
    assert_eq!(
        ask(
            &address,
            &format!("GET /{} HTTP/1.1\r\n", "x".repeat(40_000))
        ),
        ""
    );
    // Nothing was written beside the part.
    assert_eq!(bench.names(), ["circle.ngc"]);
    drop(run);
    bench.refuses(&["watch", "missing.ngc"], &["missing.ngc"]);
    bench.refuses(&["watch", "-"], &["stdin cannot be watched"]);
}
