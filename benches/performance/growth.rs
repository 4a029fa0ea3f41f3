//! How time and memory grow with the mesh; every size in a process of its own, for the sake of its peak memory.

use std::process::Command;
use std::{env, fs};

use sketchmatch::alignment::prepared::PreparedMesh;
use sketchmatch::mesh::formats::{Format, Limits};
use sketchmatch::mesh::validation::import;
use sketchmatch::numerics::Unwatched;

use crate::table::{Reach, Sample, Table, cpu, timed};
use crate::{known, pen, shapes};

/// The argument that makes a process such a child; the stage and the size follow.
pub const CHILD: &str = "--one-size";

/// Prints CPU milliseconds of every run and the peak memory in MB.
pub fn child(stage: &str, size: usize) {
    let sample = match stage {
        "picture" => {
            let picture = pen::png(&shapes::line(), size as u32);
            let decoding = timed(|| image::load_from_memory(&picture).expect("the picture is one")).median();
            forget_peak();
            timed(|| shapes::read(&picture)).less(decoding)
        }
        "svg" => {
            let svg = pen::svg(&shapes::line(), size);
            forget_peak();
            timed(|| shapes::read_svg(&svg))
        }
        stage => of_mesh(stage, size),
    };
    println!("{} {} {}", sample.quantile(0.0), sample.median(), sample.quantile(1.0));
    println!("{}", peak());
}

fn of_mesh(stage: &str, frequency: usize) -> Sample {
    let mesh = shapes::body(frequency);
    let file = if stage.starts_with("mending") { shapes::broken(&mesh) } else { String::new() };
    forget_peak();
    let mended = |triangles: usize| {
        let limits = Limits { triangles, ..Limits::default() };
        timed(|| import(file.as_bytes(), Format::Obj, &limits).expect("the body can be mended"))
    };
    match stage {
        "eigenpairs" => timed(|| known::eigenpairs(&mesh, 50)),
        "mending" => mended(mesh.triangles().len()),
        "mending to a quarter" => mended(mesh.triangles().len() / 4),
        _ => Sample::new(vec![{
            let begun = cpu();
            std::hint::black_box(PreparedMesh::new(&mesh, &Unwatched).expect("nobody cancels"));
            cpu() - begun
        }]),
    }
}

/// Makes the memory held now the peak.
fn forget_peak() {
    // Where the system does not know of it the peak is that of making the mesh, if it is higher.
    let _ = fs::write("/proc/self/clear_refs", "5");
}

/// VmHWM in MB.
fn peak() -> f64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or("0 kB");
    line.trim().trim_end_matches(" kB").parse::<f64>().unwrap_or(0.0) / 1024.0
}

/// The stages over the sizes, with the exponents of the lines through their logarithms.
pub fn rows(table: &Table, vast: bool) {
    let sizes = [(shapes::SMALL, "5K"), (shapes::MIDDLE, "25K"), (shapes::HUGE, "100K"), (shapes::VAST, "400K")];
    let sizes = &sizes[..if vast { 4 } else { 3 }];
    let files = &[(shapes::LARGE, "100K triangles"), (shapes::MILLION, "1M triangles")];
    let stages = [
        ("eigenpairs", "eigenpairs k = 50", sizes),
        ("preparation", "preparation", sizes),
        ("mending", "reading and mending", files),
        ("mending to a quarter", "reading, mending and making coarser, to a quarter", files),
    ];
    for (stage, name, sizes) in stages {
        let mut places = Vec::new();
        for (frequency, size) in sizes {
            let (sample, peak) = measured(stage, *frequency);
            let name = format!("growth: {name}, {size} (peak {peak:.0} MB)");
            table.time(&name, &sample, None, Reach::None);
            places.push(((4 * frequency * frequency) as f64, sample.median()));
        }
        table.figure(&format!("growth: exponent of {name}"), slope(&places), "", Some(1.25));
    }
}

/// How drawings are read, decoding of pictures aside.
pub fn of_drawings(table: &Table) {
    for (stage, size, what, most) in [
        ("picture", 1024, "PNG of 1024 × 1024", 60.0),
        ("picture", 8192, "PNG of 64 megapixels", 1000.0),
        ("svg", 1000, "SVG of 1,000 paths", 60.0),
    ] {
        let (sample, peak) = measured(stage, size);
        table.time(&format!("reading a drawing: {what} (peak {peak:.0} MB)"), &sample, None, Reach::Most(most));
    }
}

/// What a child says of a stage: its time, and its peak memory in MB.
fn measured(stage: &str, size: usize) -> (Sample, f64) {
    let program = env::current_exe().expect("a program has a path");
    let output = Command::new(program).args([CHILD, stage, &size.to_string()]).output();
    let text = String::from_utf8(output.expect("the child runs").stdout).expect("the child prints numbers");
    let numbers: Vec<f64> = text.split_whitespace().filter_map(|number| number.parse().ok()).collect();
    let [low, middle, high, peak] = numbers[..] else { panic!("the child said {text:?}") };
    (Sample::new(vec![low, middle, high]), peak)
}

fn slope(places: &[(f64, f64)]) -> f64 {
    let n = places.len() as f64;
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| places.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(&|p| p.0.ln()), mean(&|p| p.1.ln()));
    mean(&|p| (p.0.ln() - x) * (p.1.ln() - y)) / mean(&|p| (p.0.ln() - x).powi(2))
}
