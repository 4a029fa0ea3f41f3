//! The squares of two greys that programs show where a picture is transparent, kept in the picture by a screenshot.

use std::collections::BTreeMap;

use super::canvas::Canvas;
use super::colours::apart;
use crate::raster::PixelBox;
use crate::raster::bitmap::Bitmap;
use crate::raster::neighbourhood::dilated;

/// How far two greys differ in a channel, in 255ths: by less they are one ground, by more they are drawn.
const LEAST_APART: u8 = 12;
const MOST_APART: u8 = 96;

/// How far red, green and blue of a grey differ, in 255ths.
const COLOURLESS: u8 = 10;

/// How far pixels of one grey differ, in 255ths, and in parts of the difference of both.
const GRAIN: u8 = 6;
const OF_DIFFERENCE: f64 = 0.35;

/// The share of the border that is one of the greys or between them, and the least of either.
const ON_BORDER: f64 = 0.75;
const EITHER: f64 = 0.25;

/// Squares there are along the border at least, and how much wider than most the widest is, where a figure does not lie
/// between.
const LEAST_SQUARES: usize = 24;
const WIDEST: usize = 3;

/// How far from the other grey a pixel of a square is at most, in parts of the square's side; and how far the soft edge
/// between two squares reaches, in pixels.
const WITHIN: f64 = 0.75;
const SOFT: f64 = 1.5;

/// The canvas with nothing where such squares are; none where it has none.
pub(crate) fn without_checkerboard(canvas: &Canvas) -> Option<Canvas> {
    let colours = canvas.on_page();
    let border = walked(canvas.own);
    let on_border: Vec<[u8; 3]> = border.iter().flatten().map(|&[x, y]| colours[y * canvas.width + x]).collect();
    let greys = Greys::of(&on_border)?;
    let side = greys.side(&border, |[x, y]| colours[y * canvas.width + x])?;
    let of_grey = |which: usize| {
        let mut all = Bitmap::new(canvas.width, canvas.height);
        let pixels = colours.iter().enumerate().filter(|&(_, &colour)| greys.grey(colour) == Some(which));
        pixels.for_each(|(k, _)| all.set(k % canvas.width, k / canvas.width));
        all
    };
    let both = [of_grey(0), of_grey(1)];
    let [light, dark] = [0, 1].map(|k| both[k].and(&dilated(&both[1 - k], WITHIN * side)));
    let squares = light.or(&dark);
    let beside = dilated(&squares, SOFT);
    let mut pixels = canvas.pixels.clone();
    for y in 0..canvas.height {
        for x in beside.runs(y).flatten() {
            let at = y * canvas.width + x;
            if squares.get(x, y) || greys.is_between(colours[at]) {
                pixels[at] = [0; 4];
            }
        }
    }
    Some(Canvas { pixels, ..canvas.clone() })
}

/// The pixels along the four sides of a box.
fn walked(PixelBox { low: [left, top], high: [right, bottom] }: PixelBox) -> [Vec<[usize; 2]>; 4] {
    let across = |y: usize| (left..right).map(|x| [x, y]).collect();
    let down = |x: usize| (top..bottom).map(|y| [x, y]).collect();
    [across(top), across(bottom - 1), down(left), down(right - 1)]
}

/// The two greys of a checkerboard.
struct Greys {
    colours: [[u8; 3]; 2],
    /// How far pixels of one grey differ, in 255ths.
    grain: u8,
}

impl Greys {
    /// Those that most of the border has; none where it has others.
    fn of(border: &[[u8; 3]]) -> Option<Greys> {
        let first = most_frequent(border.iter().copied())?;
        let second = most_frequent(border.iter().copied().filter(|&colour| apart(colour, first) >= LEAST_APART))?;
        let difference = apart(first, second);
        let is_grey = |[r, g, b]: [u8; 3]| r.max(g).max(b) - r.min(g).min(b) <= COLOURLESS;
        if difference > MOST_APART || !is_grey(first) || !is_grey(second) {
            return None;
        }
        let grain = GRAIN.max((OF_DIFFERENCE * f64::from(difference)) as u8);
        let greys = Greys { colours: [first, second], grain };
        let count = |is: &dyn Fn([u8; 3]) -> bool| border.iter().filter(|&&colour| is(colour)).count() as f64;
        let all = border.len() as f64;
        let of_either = [0, 1].map(|which| count(&|colour| greys.grey(colour) == Some(which)));
        let is_both = of_either.iter().all(|&of_one| of_one >= EITHER * all);
        (is_both && count(&|colour| greys.is_between(colour)) >= ON_BORDER * all).then_some(greys)
    }

    /// Which of the two a colour is.
    fn grey(&self, colour: [u8; 3]) -> Option<usize> {
        (0..2).find(|&which| apart(colour, self.colours[which]) <= self.grain)
    }

    /// Whether a colour is one of them or lies between.
    fn is_between(&self, colour: [u8; 3]) -> bool {
        let [a, b] = self.colours;
        (0..3).all(|i| {
            let (low, high) = (a[i].min(b[i]).saturating_sub(self.grain), a[i].max(b[i]).saturating_add(self.grain));
            (low..=high).contains(&colour[i])
        })
    }

    /// The side of a square, in pixels; none where the greys do not take turns along the border.
    fn side(&self, border: &[Vec<[usize; 2]>; 4], colour: impl Fn([usize; 2]) -> [u8; 3]) -> Option<f64> {
        let mut sides = Vec::new();
        for line in border {
            let greys: Vec<usize> = line.iter().filter_map(|&at| self.grey(colour(at))).collect();
            sides.extend(greys.chunk_by(|a, b| a == b).map(<[usize]>::len));
        }
        sides.sort_unstable();
        let middle = *sides.get(sides.len() / 2)?;
        let widest = sides.iter().rev().copied().find(|&side| side <= WIDEST * middle)?;
        let wide: usize = sides.iter().filter(|&&side| side > WIDEST * middle).sum();
        let is_regular =
            sides.len() >= LEAST_SQUARES && (wide as f64) < (1.0 - ON_BORDER) * sides.iter().sum::<usize>() as f64;
        is_regular.then_some(widest as f64)
    }
}

/// The mean of the colours that lie in the same 32nd of each channel as most do.
fn most_frequent(colours: impl Iterator<Item = [u8; 3]> + Clone) -> Option<[u8; 3]> {
    let bin = |colour: [u8; 3]| colour.map(|value| value / 8);
    let mut counts = BTreeMap::new();
    colours.clone().for_each(|colour| *counts.entry(bin(colour)).or_insert(0) += 1);
    let (most, _) = counts.into_iter().max_by_key(|&(_, count)| count)?;
    let own: Vec<[u8; 3]> = colours.filter(|&colour| bin(colour) == most).collect();
    Some([0, 1, 2].map(|i| (own.iter().map(|colour| u64::from(colour[i])).sum::<u64>() / own.len() as u64) as u8))
}
