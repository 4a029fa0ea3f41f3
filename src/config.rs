//! The command line and the environment: every owner's configuration, gathered.

use std::net::SocketAddr;
use std::path::PathBuf;

use anyhow::ensure;
use clap::{Args, Parser, Subcommand};

use crate::telemetry::LogFormat;
use sketchmatch::http::pictures::Form;
use sketchmatch::{example, http, store, worker};

/// Matches 2D sketches to 3D meshes by functional maps.
#[derive(Debug, Parser)]
#[command(version, about)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
    /// What is logged: a level, or levels by module.
    #[arg(long, env = "SKETCHMATCH_LOG", default_value = "info", global = true)]
    pub log: String,
    #[arg(long, env = "SKETCHMATCH_LOG_FORMAT", default_value = "text", global = true)]
    pub log_format: LogFormat,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Serves the REST interface, with its workers in the process.
    Serve(ServeOptions),
    /// Matches a sketch to a mesh without a server.
    Match(MatchOptions),
    /// Writes the example creatures, their sketches and the true correspondences.
    Example(ExampleOptions),
    /// Prints the OpenAPI document.
    Openapi,
}

#[derive(Debug, Args)]
pub struct ServeOptions {
    /// Address and port to listen on.
    #[arg(long, env = "SKETCHMATCH_LISTEN", default_value = "127.0.0.1:8080")]
    pub listen: SocketAddr,
    /// Directory of the database and the blobs.
    #[arg(long, env = "SKETCHMATCH_DATA_DIR", default_value = "data")]
    pub data_dir: PathBuf,
    /// Matches computed at one time [default: the number of processors].
    #[arg(long, env = "SKETCHMATCH_WORKERS", value_parser = clap::value_parser!(u16).range(1..))]
    pub workers: Option<u16>,
    /// Serve anybody who can reach an address that is not loopback.
    #[arg(long, env = "SKETCHMATCH_NO_AUTH")]
    pub no_auth: bool,
    /// Origin that scripts of other sites may call from, or `*`; may be repeated.
    #[arg(long = "cors-origin", env = "SKETCHMATCH_CORS_ORIGIN", value_delimiter = ',')]
    pub cors_origins: Vec<String>,
    /// Largest mesh or sketch file in bytes.
    #[arg(long, env = "SKETCHMATCH_MAX_UPLOAD_BYTES", default_value_t = http::Config::default().max_upload_bytes)]
    pub max_upload_bytes: usize,
    /// Largest JSON request and SVG in bytes.
    #[arg(long, env = "SKETCHMATCH_MAX_REQUEST_BYTES", default_value_t = http::Config::default().max_request_bytes)]
    pub max_request_bytes: usize,
    /// Bytes of all uploads that are in memory at one time.
    #[arg(long, env = "SKETCHMATCH_MAX_UPLOADS_BYTES", default_value_t = http::Config::default().max_uploads_bytes)]
    pub max_uploads_bytes: usize,
    /// Largest mesh in triangles.
    #[arg(long, env = "SKETCHMATCH_MAX_TRIANGLES", default_value_t = http::Config::default().max_triangles)]
    pub max_triangles: usize,
    /// Most eigenpairs of a spectrum that can be asked for.
    #[arg(long, env = "SKETCHMATCH_MAX_EIGENPAIRS", default_value_t = http::Config::default().max_eigenpairs)]
    pub max_eigenpairs: usize,
    /// Bytes of memory one job may take, as estimated from its shapes before it is queued.
    #[arg(long, env = "SKETCHMATCH_MAX_JOB_MEMORY", default_value_t = http::Config::default().max_job_memory)]
    pub max_job_memory: usize,
    /// Most jobs that wait.
    #[arg(long, env = "SKETCHMATCH_MAX_QUEUE", default_value_t = http::Config::default().max_queue)]
    pub max_queue: usize,
}

#[derive(Debug, Args)]
pub struct MatchOptions {
    /// JSON outline, SVG, PNG or JPEG.
    pub sketch: PathBuf,
    /// OBJ, OFF, PLY, STL or GLB.
    pub mesh: PathBuf,
    /// A match request as JSON; `mesh` and `sketch` may be left out.
    #[arg(long, env = "SKETCHMATCH_REQUEST")]
    pub request: Option<PathBuf>,
    /// Where the result goes [default: standard output].
    #[arg(short, long, env = "SKETCHMATCH_OUTPUT")]
    pub output: Option<PathBuf>,
    /// Where a picture of the match goes, by the file's ending: .png, .svg, or .glb for the coloured mesh.
    #[arg(long, env = "SKETCHMATCH_PICTURE", value_name = "FILE", value_parser = picture)]
    pub picture: Option<PictureFile>,
}

/// A file for a picture, in the form its name says.
#[derive(Clone, Debug)]
pub struct PictureFile {
    pub path: PathBuf,
    pub form: Form,
}

fn picture(path: &str) -> Result<PictureFile, String> {
    let path = PathBuf::from(path);
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_ascii_lowercase();
    let form = match ending.as_str() {
        "png" => Form::Png,
        "svg" => Form::Svg,
        "glb" => Form::Glb,
        _ => return Err("a picture is a file that ends in .png, .svg or .glb".to_owned()),
    };
    Ok(PictureFile { path, form })
}

#[derive(Debug, Args)]
pub struct ExampleOptions {
    /// Directory to write to; made where it is missing.
    pub dir: PathBuf,
    /// Vertices of each creature's mesh, about: 2000 to 100000.
    #[arg(long, env = "SKETCHMATCH_VERTICES", default_value_t = 5000, value_parser = vertices)]
    pub vertices: usize,
}

fn vertices(text: &str) -> Result<usize, String> {
    let vertices = text.parse().map_err(|error| format!("{error}"))?;
    let (least, most) = example::SIZES.into_inner();
    if (least..=most).contains(&vertices) { Ok(vertices) } else { Err(format!("from {least} to {most}")) }
}

impl ServeOptions {
    /// Refuses to serve the world without authentication unless told to in so many words.
    ///
    /// # Errors
    /// An address that is not loopback without `--no-auth`.
    pub fn check_exposure(&self) -> anyhow::Result<()> {
        let listen = self.listen;
        ensure!(
            listen.ip().is_loopback() || self.no_auth,
            "{listen} is not a loopback address, so that anybody who reaches it could use the server: say --no-auth to allow that"
        );
        Ok(())
    }

    pub fn http(&self) -> http::Config {
        http::Config {
            cors_origins: self.cors_origins.clone(),
            max_upload_bytes: self.max_upload_bytes,
            max_request_bytes: self.max_request_bytes,
            max_uploads_bytes: self.max_uploads_bytes,
            max_triangles: self.max_triangles,
            max_eigenpairs: self.max_eigenpairs,
            max_job_memory: self.max_job_memory,
            max_queue: self.max_queue,
        }
    }

    pub fn store(&self) -> store::Config {
        store::Config { data_dir: self.data_dir.clone() }
    }

    pub fn worker(&self) -> worker::Config {
        let default = worker::Config::default();
        worker::Config { workers: self.workers.map_or(default.workers, usize::from), ..default }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    fn serve(arguments: &[&str]) -> ServeOptions {
        let arguments = ["sketchmatch", "serve"].iter().chain(arguments);
        match Cli::try_parse_from(arguments).unwrap().command {
            Command::Serve(options) => options,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn the_command_line_is_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_option_has_its_variable() {
        for command in Cli::command().get_subcommands() {
            let options =
                command.get_arguments().filter(|argument| argument.get_long().is_some_and(|long| long != "help"));
            for option in options {
                let variable = option.get_env().and_then(|name| name.to_str()).unwrap_or_default();
                assert!(variable.starts_with("SKETCHMATCH_"), "{} of {}", option.get_id(), command.get_name());
            }
        }
    }

    #[test]
    fn creatures_are_asked_for_in_sizes_they_come_in() {
        let example = |vertices: &str| Cli::try_parse_from(["sketchmatch", "example", "d", "--vertices", vertices]);
        assert!(example("2000").is_ok() && example("100000").is_ok());
        assert!(example("1999").is_err() && example("100001").is_err() && example("many").is_err());
    }

    #[test]
    fn a_picture_comes_in_the_form_its_name_says() {
        let form = |file: &str| {
            let arguments = ["sketchmatch", "match", "sketch.svg", "mesh.off", "--picture", file];
            match Cli::try_parse_from(arguments).map(|cli| cli.command) {
                Ok(Command::Match(MatchOptions { picture: Some(picture), .. })) => Ok(picture.form),
                other => Err(format!("{other:?}")),
            }
        };
        assert_eq!((form("a/b.png"), form("b.SVG"), form("b.c.glb")), (Ok(Form::Png), Ok(Form::Svg), Ok(Form::Glb)));
        for file in ["b.jpg", "png", ".png", "b.", ""] {
            assert!(form(file).unwrap_err().contains(".png, .svg or .glb"), "{file}");
        }
    }

    #[test]
    fn only_loopback_is_served_unasked() {
        assert!(serve(&[]).check_exposure().is_ok());
        assert!(serve(&["--listen", "[::1]:8080"]).check_exposure().is_ok());
        assert!(serve(&["--listen", "0.0.0.0:8080"]).check_exposure().is_err());
        assert!(serve(&["--listen", "0.0.0.0:8080", "--no-auth"]).check_exposure().is_ok());
    }
}
