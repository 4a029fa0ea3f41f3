//! Clients that send much and hang up.

use std::io::Write;
use std::net::TcpStream;
use std::time::{Duration, Instant};
use std::{fs, thread};

use image::{GrayImage, ImageFormat, Luma};
use reqwest::Client;

use crate::client::client;
use crate::drawings::encoded;
use crate::program::Program;

/// Pixels a side of a picture that is reckoned to take a hundred megabytes to read.
const SIDE: u32 = 2500;

/// What reading one such picture is reckoned to take.
const RECKONED: u64 = SIDE as u64 * SIDE as u64 * 23;

/// How long all of this may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(300);

/// A number among the measures.
async fn measure(client: &Client, program: &Program, name: &str) -> u64 {
    let text = client.get(program.url("/metrics")).send().await.unwrap().text().await.unwrap();
    let value = text.lines().find_map(|line| line.strip_prefix(name)?.trim().parse::<f64>().ok());
    value.unwrap_or_else(|| panic!("{text}")) as u64
}

/// The most memory the program has had so far, in bytes.
fn peak(program: &Program) -> u64 {
    let status = fs::read_to_string(format!("/proc/{}/status", program.child.id())).unwrap();
    let kibibytes =
        status.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB")?.parse().ok());
    kibibytes.map(|kibibytes: u64| kibibytes << 10).unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn pictures_whose_senders_hang_up_are_read_one_after_the_other() {
    let data = tempfile::tempdir().unwrap();
    let program = Program::with(data.path(), &["--max-reading-bytes", &RECKONED.to_string()]);
    let client = client();
    let before = peak(&program);
    let picture = GrayImage::from_fn(SIDE, SIDE, |x, y| Luma([if x > 99 && y > 99 && x + y < SIDE { 0 } else { 255 }]));
    let picture = encoded(picture, ImageFormat::Png);
    let head = format!(
        "POST /v1/sketches HTTP/1.1\r\nhost: {}\r\ncontent-type: image/png\r\ncontent-length: {}\r\n\r\n",
        program.authority(),
        picture.len()
    );
    let started = Instant::now();
    let mut alone = 0;
    for round in 0..3 {
        let mut connections: Vec<TcpStream> =
            (0..4).map(|_| TcpStream::connect(program.authority()).unwrap()).collect();
        for connection in &mut connections {
            connection.write_all(head.as_bytes()).and_then(|()| connection.write_all(&picture)).unwrap();
        }
        while measure(&client, &program, "sketchmatch_reading_bytes").await == 0 {
            assert!(started.elapsed() < PATIENCE, "nothing is read");
            thread::sleep(Duration::from_millis(5));
        }
        drop(connections);
        if round == 0 {
            // The work of those who hung up goes on, or comes to its end, with its memory still counted.
            while measure(&client, &program, "sketchmatch_reading_bytes").await > 0 {
                assert!(started.elapsed() < PATIENCE, "the memory is not given back");
                thread::sleep(Duration::from_millis(20));
            }
            alone = peak(&program) - before;
        }
    }
    while measure(&client, &program, "sketchmatch_reading_bytes").await > 0 {
        assert!(started.elapsed() < PATIENCE, "the memory is not given back");
        thread::sleep(Duration::from_millis(20));
    }
    let peak = peak(&program) - before;
    assert!(peak < alone + alone / 2, "{peak} bytes at one time, {alone} for one picture");
}
