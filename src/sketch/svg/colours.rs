//! Colours as newer style sheets write them, in the words of older ones.

use std::borrow::Cow;

use super::calls::{Conversion, first, in_older_words};

/// Functions for colours, and what they mean.
const FUNCTIONS: [(&str, Conversion); 4] =
    [("light-dark", light), ("oklch", oklch), ("oklab", oklab), ("color", of_space)];

/// What numbers in per cent are of, where 100 % are not 1: the chroma of `oklch`, and both axes of `oklab`.
const WHOLE_CHROMA: f64 = 0.4;

/// The text with all colours that can be said in older words.
pub(super) fn plain(text: &str) -> Cow<'_, str> {
    in_older_words(text, &FUNCTIONS)
}

/// Of the colours for a light and for a dark page the first.
fn light(arguments: &str) -> Option<String> {
    Some(first(arguments).trim().to_owned())
}

fn oklch(arguments: &str) -> Option<String> {
    let ([lightness, chroma, hue], opacity) = numbers(arguments, [1.0, WHOLE_CHROMA, 360.0])?;
    let (sine, cosine) = hue.to_radians().sin_cos();
    Some(written(of_oklab([lightness, chroma * cosine, chroma * sine]), opacity))
}

fn oklab(arguments: &str) -> Option<String> {
    let (colour, opacity) = numbers(arguments, [1.0, WHOLE_CHROMA, WHOLE_CHROMA])?;
    Some(written(of_oklab(colour), opacity))
}

/// A colour of a named space. That of screens with more colours is taken for the common one: it is a little paler so.
fn of_space(arguments: &str) -> Option<String> {
    let (space, numbers_of) = arguments.trim().split_once(' ')?;
    let (colour, opacity) = numbers(numbers_of, [1.0; 3]).filter(|_| ["srgb", "display-p3"].contains(&space))?;
    Some(written(colour, opacity))
}

/// Three numbers and the opacity behind a `/`; `wholes` are what 100 % of each are.
fn numbers(arguments: &str, wholes: [f64; 3]) -> Option<([f64; 3], f64)> {
    let (colour, opacity) = arguments.split_once('/').unwrap_or((arguments, "1"));
    let words: Vec<&str> = colour.split_ascii_whitespace().collect();
    let words: [&str; 3] = words.try_into().ok()?;
    let [a, b, c] = [0, 1, 2].map(|i| number(words[i], wholes[i]));
    Some(([a?, b?, c?], number(opacity.trim(), 1.0)?))
}

fn number(word: &str, whole: f64) -> Option<f64> {
    let number = match word.strip_suffix('%') {
        Some(hundredths) => hundredths.parse::<f64>().ok()? * whole / 100.0,
        None if word == "none" => 0.0,
        None => word.strip_suffix("deg").unwrap_or(word).parse().ok()?,
    };
    number.is_finite().then_some(number)
}

/// Red, green and blue in sRGB of a colour in Oklab.
fn of_oklab([lightness, a, b]: [f64; 3]) -> [f64; 3] {
    let cones = [
        lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b,
        lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b,
        lightness - 0.089_484_177_5 * a - 1.291_485_548 * b,
    ];
    let [l, m, s] = cones.map(|x| x * x * x);
    let linear = [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701 * s,
    ];
    linear.map(|x| if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 })
}

/// A colour of numbers in `[0, 1]`.
fn written(colour: [f64; 3], opacity: f64) -> String {
    let [red, green, blue] = colour.map(|x| (255.0 * x.clamp(0.0, 1.0)).round());
    match opacity.clamp(0.0, 1.0) {
        1.0 => format!("rgb({red},{green},{blue})"),
        opacity => format!("rgba({red},{green},{blue},{opacity})"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_said_in_older_words() {
        for (new, old) in [
            ("light-dark(rgb(1, 2, 3), #fff)", "rgb(1, 2, 3)"),
            ("oklch(100% 0 none)", "rgb(255,255,255)"),
            ("oklch(0.628 0.2577 29.23deg)", "rgb(255,0,0)"),
            ("light-dark(oklab(0 0 0 / 50%), red)", "rgba(0,0,0,0.5)"),
            ("color(display-p3 0.8 0.4 0)", "rgb(204,102,0)"),
            ("oklch(from red l c h)", "oklch(from red l c h)"),
            ("color(xyz 1 1 1)", "color(xyz 1 1 1)"),
        ] {
            assert_eq!(plain(new), old);
        }
    }
}
