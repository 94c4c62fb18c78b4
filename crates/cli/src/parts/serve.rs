//! A page for the browsers of this computer alone, which reload it when it changes.

use crate::output::Failure;
use std::io::{self, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Longest head of a request, bytes; browsers send less than a tenth.
const LONGEST_HEAD: usize = 16_384;
/// How long a browser may take to send its request, and to take the answer.
const PATIENCE: Duration = Duration::from_secs(10);
/// Most connections at one time: browsers open six and more ahead of need.
const MOST_CONNECTIONS: usize = 64;

/// The page that is shown, with the number of pages before it.
#[derive(Default)]
struct Shown {
    version: u64,
    html: String,
}

/// Serves a page on 127.0.0.1.
pub(super) struct Server {
    address: SocketAddr,
    shown: Arc<Mutex<Shown>>,
}

impl Server {
    /// Listens on a port of this computer, 0 for a free one.
    pub(super) fn start(port: u16) -> Result<Server, Failure> {
        let refused = |error: io::Error| {
            Failure::with_hint(
                format!("cannot listen on port {port} of 127.0.0.1: {error}"),
                "leave --port out, and a free one is taken",
            )
        };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(refused)?;
        let address = listener.local_addr().map_err(refused)?;
        let shown = Arc::new(Mutex::new(Shown::default()));
        let server = Server {
            address,
            shown: Arc::clone(&shown),
        };
        std::thread::spawn(move || accept(&listener, address, &shown));
        Ok(server)
    }

    /// Where the page is.
    pub(super) fn address(&self) -> String {
        format!("http://{}/", self.address)
    }

    /// Shows another page; open ones reload themselves.
    pub(super) fn show(&self, page: &str) {
        let mut shown = lock(&self.shown);
        shown.version += 1;
        shown.html = reloading(page, shown.version);
    }
}

fn lock(shown: &Mutex<Shown>) -> MutexGuard<'_, Shown> {
    // A page is replaced as a whole: one that a panic has left is a whole one.
    shown.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The page with a script that asks for its version once a second, and may ask this server alone.
fn reloading(page: &str, version: u64) -> String {
    let page = page.replacen(
        "default-src 'none';",
        "default-src 'none'; connect-src 'self';",
        1,
    );
    let script = format!(
        "<script>setInterval(async () => {{ try {{ const now = await (await fetch(\"version\")).text(); if (now !== \"{version}\") location.reload(); }} catch {{}} }}, 1000);</script>"
    );
    match page.rfind("</body>") {
        Some(end) => format!("{}{script}{}", &page[..end], &page[end..]),
        None => page + &script,
    }
}

fn accept(listener: &TcpListener, address: SocketAddr, shown: &Arc<Mutex<Shown>>) {
    let open = Arc::new(AtomicUsize::new(0));
    for stream in listener.incoming().flatten() {
        if open.fetch_add(1, Ordering::SeqCst) >= MOST_CONNECTIONS {
            open.fetch_sub(1, Ordering::SeqCst);
            continue;
        }
        let (open, shown) = (Arc::clone(&open), Arc::clone(shown));
        // A browser that opens a connection and says nothing must not keep others waiting.
        std::thread::spawn(move || {
            // A browser that has gone needs no answer.
            let _ = answer(stream, address, &shown);
            open.fetch_sub(1, Ordering::SeqCst);
        });
    }
}

fn answer(mut stream: TcpStream, address: SocketAddr, shown: &Mutex<Shown>) -> io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let Some(head) = head(&mut stream)? else {
        return Ok(());
    };
    let (status, kind, body) = respond(&head, address, shown);
    let headers = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}; charset=utf-8\r\nContent-Length: {}\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n",
        body.len()
    );
    stream.write_all(headers.as_bytes())?;
    stream.write_all(body.as_bytes())?;
    stream.flush()
}

/// The head of a request; `None` for one that is too long, or ends before it is complete.
fn head(stream: &mut TcpStream) -> io::Result<Option<String>> {
    let (mut head, mut buffer) = (Vec::new(), [0; 1024]);
    loop {
        let read = stream.read(&mut buffer)?;
        head.extend_from_slice(buffer.get(..read).unwrap_or_default());
        if head.windows(4).any(|four| four == b"\r\n\r\n") {
            return Ok(Some(String::from_utf8_lossy(&head).into_owned()));
        }
        if read == 0 || head.len() > LONGEST_HEAD {
            return Ok(None);
        }
    }
}

/// Status, kind and body of the answer to a request.
fn respond(
    head: &str,
    address: SocketAddr,
    shown: &Mutex<Shown>,
) -> (&'static str, &'static str, String) {
    let refuse = |status, why: &str| (status, "text/plain", format!("{why}\n"));
    let mut lines = head.lines();
    let mut request = lines.next().unwrap_or_default().split(' ');
    let (method, path) = (request.next(), request.next());
    // A name that another site has pointed here is not this computer's own.
    let host = lines
        .filter_map(|line| line.split_once(':'))
        .find(|(name, _)| name.eq_ignore_ascii_case("host"))
        .map(|(_, value)| value.trim().to_owned());
    let port = address.port();
    let own = [format!("127.0.0.1:{port}"), format!("localhost:{port}")];
    if !host.is_some_and(|host| own.contains(&host)) {
        return refuse("403 Forbidden", "this page is for this computer alone");
    }
    match (method, path) {
        (Some("GET"), Some("/")) => ("200 OK", "text/html", lock(shown).html.clone()),
        (Some("GET"), Some("/version")) => {
            ("200 OK", "text/plain", lock(shown).version.to_string())
        }
        (Some("GET"), _) => refuse("404 Not Found", "there is the page alone"),
        _ => refuse("405 Method Not Allowed", "pages are asked for with GET"),
    }
}
