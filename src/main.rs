//! The program: serves, matches without a server, writes the example, prints the OpenAPI document.

mod config;
mod telemetry;

use std::error::Error;
use std::fs;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, anyhow};
use clap::Parser;
use serde_json::{Value, json};
use tokio::net::TcpListener;
use tokio::signal::unix::{SignalKind, signal};
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;

use config::{Cli, Command, ExampleOptions, MatchOptions, PictureFile, ServeOptions};
use sketchmatch::http::problem::Problem;
use sketchmatch::http::{self, App, pictures};
use sketchmatch::mesh::formats::Limits;
use sketchmatch::numerics::Cancelled;
use sketchmatch::pipeline::request::MatchRequest;
use sketchmatch::pipeline::{self, Computing, Settings, Stage, Surroundings, Watcher};
use sketchmatch::store::Store;
use sketchmatch::{example, sketch, worker};

fn main() -> anyhow::Result<()> {
    let Cli { command, log, log_format } = Cli::parse();
    telemetry::log(&log, log_format)?;
    match command {
        Command::Serve(options) => serve(&options),
        Command::Match(options) => matched(&options),
        Command::Example(options) => write_example(&options),
        Command::Openapi => {
            println!("{:#}", http::openapi::document());
            Ok(())
        }
    }
}

/// Serves until SIGTERM or SIGINT, then lets requests and jobs come to an end.
#[tokio::main]
async fn serve(options: &ServeOptions) -> anyhow::Result<()> {
    options.check_exposure()?;
    let measures = telemetry::measures()?;
    let store = Store::open(&options.store()).await?;
    let listener =
        TcpListener::bind(options.listen).await.with_context(|| format!("listening on {}", options.listen))?;
    let shutdown = CancellationToken::new();
    stop_on_signal(shutdown.clone())?;
    tracing::info!(address = %listener.local_addr()?, "listening");
    let working = tokio::spawn(worker::run(store.clone(), options.worker(), shutdown.clone()));
    let serving = http::serve(listener, App::new(store, options.http(), measures, shutdown));
    tokio::try_join!(async { serving.await.context("serving") }, ended(working))?;
    tracing::info!("stopped");
    Ok(())
}

/// How the workers ended, a panic among the errors.
async fn ended<E: Error + Send + Sync + 'static>(working: JoinHandle<Result<(), E>>) -> anyhow::Result<()> {
    working.await.context("the workers broke off")?.context("starting the workers")
}

/// Cancels `shutdown` at the first SIGTERM or SIGINT.
fn stop_on_signal(shutdown: CancellationToken) -> anyhow::Result<()> {
    let (mut terminate, mut interrupt) = (signal(SignalKind::terminate())?, signal(SignalKind::interrupt())?);
    tokio::spawn(async move {
        tokio::select! {
            _ = terminate.recv() => tracing::info!("SIGTERM: stopping"),
            _ = interrupt.recv() => tracing::info!("SIGINT: stopping"),
        }
        shutdown.cancel();
    });
    Ok(())
}

/// Matches two files and writes the result.
fn matched(options: &MatchOptions) -> anyhow::Result<()> {
    let sketch = read(&options.sketch)?;
    let sketch = http::sketches::imported(&sketch, sketch_type(&options.sketch), None, &sketch::Config::default());
    let sketch = sketch.map_err(|problem| reasons(&options.sketch, &problem))?;
    let mesh_name = options.mesh.file_name().and_then(|name| name.to_str());
    let mesh = http::meshes::imported(&read(&options.mesh)?, None, None, mesh_name, &Limits::default());
    let mesh = mesh.map_err(|problem| reasons(&options.mesh, &problem))?;
    for warning in sketch.warnings.iter().map(|w| &w.detail).chain(mesh.warnings.iter().map(|w| &w.detail)) {
        tracing::warn!("{warning}");
    }
    let settings = settings(options, sketch.sketch.mesh().positions().len(), mesh.mesh.positions().len())?;
    let started = Instant::now();
    let clock = || started.elapsed().as_secs_f64() * 1e3;
    let surroundings = Surroundings { spectra: &Computing, preparations: &Computing, watcher: &Logged, clock: &clock };
    let result = pipeline::run(&sketch.sketch, &mesh.mesh, &settings, &surroundings)?;
    let text = serde_json::to_string(&result)?;
    match &options.output {
        Some(path) => fs::write(path, &text).with_context(|| format!("writing {}", path.display()))?,
        None => println!("{text}"),
    }
    if let Some(PictureFile { path, form }) = &options.picture {
        let file = pictures::file(*form, text.as_bytes(), &sketch.sketch, &mesh.mesh)?;
        fs::write(path, file).with_context(|| format!("writing {}", path.display()))?;
    }
    Ok(())
}

fn read(path: &Path) -> anyhow::Result<Vec<u8>> {
    fs::read(path).with_context(|| format!("reading {}", path.display()))
}

/// The media type of a sketch by its file's name; nothing where the bytes have to tell.
fn sketch_type(path: &Path) -> Option<&'static str> {
    match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "json" => Some("application/json"),
        "svg" => Some("image/svg+xml"),
        "png" => Some("image/png"),
        "jpg" | "jpeg" => Some("image/jpeg"),
        _ => None,
    }
}

/// The settings of the request file, or of the empty request, for shapes of these many vertices.
fn settings(options: &MatchOptions, sketch_vertices: usize, mesh_vertices: usize) -> anyhow::Result<Settings> {
    let path = options.request.as_deref().unwrap_or(Path::new("request"));
    let refused = |problem: Problem| reasons(path, &problem);
    let text = options.request.as_deref().map_or_else(|| Ok(b"{}".to_vec()), read)?;
    let mut request: Value = http::json::parsed(&text).map_err(refused)?;
    for (field, file) in [("sketch", &options.sketch), ("mesh", &options.mesh)] {
        if let Some(request) = request.as_object_mut() {
            request.entry(field).or_insert_with(|| json!(file.to_string_lossy()));
        }
    }
    let request: MatchRequest = http::json::parsed(request.to_string().as_bytes()).map_err(refused)?;
    let faults = match Settings::resolve(&request) {
        Ok(settings) => {
            let faults = pipeline::check(&settings, sketch_vertices, mesh_vertices);
            if faults.is_empty() {
                return Ok(settings);
            }
            faults
        }
        Err(faults) => faults,
    };
    let problem =
        Problem::refused("the match cannot be carried out as asked", faults.into_iter().map(Into::into).collect());
    Err(reasons(path, &problem))
}

/// A refusal as people read it: a line per reason.
fn reasons(path: &Path, problem: &Problem) -> anyhow::Error {
    let reasons = problem.errors.iter().map(|fault| {
        let place = fault.pointer.as_deref().or(fault.place.as_deref()).unwrap_or("file");
        format!("\n  {place}: {}", fault.detail)
    });
    anyhow!("{}: {}{}", path.display(), problem.detail, reasons.collect::<String>())
}

/// Logs the stages and never cancels.
struct Logged;

impl Watcher for Logged {
    fn proceed(&self, stage: Stage, fraction: f64) -> Result<(), Cancelled> {
        tracing::debug!(?stage, fraction);
        Ok(())
    }
}

/// Writes the example creatures under a directory.
fn write_example(options: &ExampleOptions) -> anyhow::Result<()> {
    for (name, bytes) in example::files(options.vertices)? {
        let path = options.dir.join(name);
        fs::create_dir_all(path.parent().unwrap_or(&options.dir))?;
        fs::write(&path, bytes).with_context(|| format!("writing {}", path.display()))?;
        println!("{}", path.display());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::future::pending;
    use std::io;

    use super::*;

    #[tokio::test]
    async fn workers_that_break_off_end_the_server() {
        let panicking: JoinHandle<io::Result<()>> = tokio::spawn(async { panic!("as told") });
        let failing = tokio::spawn(async { Err(io::Error::other("no threads")) });
        for (working, reason) in [(panicking, "broke off"), (failing, "starting")] {
            let serving = pending::<anyhow::Result<()>>();
            let error = tokio::try_join!(serving, ended(working)).unwrap_err();
            assert!(error.to_string().contains(reason), "{error:#}");
        }
    }
}
