//! Transforms as style sheets write them, in the words of attributes: numbers without units, and few functions.

use std::borrow::Cow;

use super::calls::{Conversion, in_older_words};

/// Functions for transforms, and what they mean; the depth of what is flat is nothing.
const FUNCTIONS: [(&str, Conversion); 13] = [
    ("translate", |arguments| said("translate", arguments, length)),
    ("translateX", |x| Some(format!("translate({},0)", length(x.trim())?))),
    ("translateY", |y| Some(format!("translate(0,{})", length(y.trim())?))),
    ("translate3d", |arguments| said("translate", without_depth(arguments)?, length)),
    ("scale", |arguments| said("scale", arguments, factor)),
    ("scaleX", |x| Some(format!("scale({},1)", factor(x.trim())?))),
    ("scaleY", |y| Some(format!("scale(1,{})", factor(y.trim())?))),
    ("scale3d", |arguments| said("scale", without_depth(arguments)?, factor)),
    ("rotate", |turn| Some(format!("rotate({})", degrees(turn.trim())?))),
    ("rotateZ", |turn| Some(format!("rotate({})", degrees(turn.trim())?))),
    ("skew", skew),
    ("skewX", |lean| Some(format!("skewX({})", degrees(lean.trim())?))),
    ("skewY", |lean| Some(format!("skewY({})", degrees(lean.trim())?))),
];

/// Units of angles, and their degrees. `grad` comes before `rad`, which it ends with.
const ANGLES: [(&str, f64); 4] = [("deg", 1.0), ("grad", 0.9), ("rad", 180.0 / std::f64::consts::PI), ("turn", 360.0)];

/// The text with all transforms in the words of attributes that can be said in them.
pub(super) fn plain(text: &str) -> Cow<'_, str> {
    in_older_words(text, &FUNCTIONS)
}

/// A call of a function with one or two arguments.
fn said(function: &str, arguments: &str, number: fn(&str) -> Option<String>) -> Option<String> {
    let (first, second) = arguments.split_once(',').map_or((arguments, None), |(a, b)| (a, Some(b)));
    let first = number(first.trim())?;
    Some(match second {
        Some(second) => format!("{function}({first},{})", number(second.trim())?),
        None => format!("{function}({first})"),
    })
}

/// The first two of three arguments.
fn without_depth(arguments: &str) -> Option<&str> {
    arguments.rsplit_once(',').map(|(flat, _)| flat).filter(|flat| flat.contains(','))
}

/// Both axes leant at once, which is not the one after the other.
fn skew(arguments: &str) -> Option<String> {
    let (across, down) = arguments.split_once(',').unwrap_or((arguments, "0"));
    let [across, down] = [across, down].map(|lean| Some(finite(&degrees(lean.trim())?)?.to_radians().tan()));
    Some(format!("matrix(1,{},{},1,0,0)", down?, across?))
}

/// A length in pixels, as it is written; what is of the size of a box, of a font or of paper is not known here.
fn length(word: &str) -> Option<String> {
    let number = word.strip_suffix("px").unwrap_or(word);
    finite(number).map(|_| number.to_owned())
}

/// A number, or so many per cent.
fn factor(word: &str) -> Option<String> {
    match word.strip_suffix('%') {
        Some(hundredths) => finite(hundredths).map(|number| (number / 100.0).to_string()),
        None => finite(word).map(|_| word.to_owned()),
    }
}

/// An angle in degrees.
fn degrees(word: &str) -> Option<String> {
    match ANGLES.iter().find_map(|(unit, degrees)| Some((word.strip_suffix(unit)?, degrees))) {
        Some((number, degrees)) => finite(number).map(|number| (number * degrees).to_string()),
        None => finite(word).map(|_| word.to_owned()),
    }
}

fn finite(word: &str) -> Option<f64> {
    word.parse().ok().filter(|number: &f64| number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transforms_of_style_sheets_are_said_in_words_of_attributes() {
        for (new, old) in [
            ("translate(175px, 20px) rotate(-20deg)", "translate(175,20) rotate(-20)"),
            ("translate(5px)", "translate(5)"),
            ("scaleX(-1) translateX(-300px)", "scale(-1,1) translate(-300,0)"),
            ("scaleY(50%) translateY( -1.5e1px )", "scale(1,0.5) translate(0,-1.5e1)"),
            ("translate3d(1px, 2px, 0) scale3d(2, 3, 1) scale(2)", "translate(1,2) scale(2,3) scale(2)"),
            ("skew(0, 45deg)", "matrix(1,0.9999999999999999,0,1,0,0)"),
            ("rotate(0.25turn) rotateZ(100grad) skewX(1rad)", "rotate(90) rotate(90) skewX(57.29577951308232)"),
        ] {
            assert_eq!(plain(new), old);
        }
        for same in [
            "translate(10 20) rotate(30 1 2) rotate(30, 1, 2) scale(2-1) matrix(1,0,0,1,5,5)",
            "translate(50%, 0) translate(1em,2px) translateX(calc(1px + 2px)) rotate(infdeg) translate3d(1px,2px)",
            "rotate3d(0,0,1,20deg) perspective(9px) my-rotate(1deg)",
        ] {
            assert_eq!(plain(same), same);
        }
    }
}
