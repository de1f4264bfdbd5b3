//! From the JSON tree to models and curves.

use fairform::sphere::{Blend, Ends, Knots, Rule};
use fairform::streamline::{
    self, Detail, Grid, InitialCurve, Integration, LengthFunction, MAX_DEPTH, Model, Order, Start,
    spaced,
};
use fairform::{Scheme, Vec3};

use super::node::{
    At, Node, Object, flag, kept, number, numbers, points, positive, text, unit, vector,
};
use super::{Contents, Curve, MAX_ORDER, MAX_SAMPLES, Models, Patch, Stitch, VERSION};
use crate::error::ParseError;

type Read<T> = Result<T, ParseError>;

const HEAD: &[&str] = &["version", "kind", "name", "display"];
const SURFACE: &[&str] = &[
    "tangents",
    "s",
    "lengths",
    "t",
    "scheme",
    "order",
    "ends",
    "w",
    "depth",
    "initial",
    "s0",
    "length",
    "integration",
    "blend",
    "details",
];
const CURVE: &[&str] = &[
    "scheme",
    "tangents",
    "depth",
    "ends",
    "closed",
    "w",
    "s",
    "s0",
    "start",
    "integration",
    "blend",
];
const QI: &[&str] = &["scheme", "tangents", "order", "knots", "length", "start", "samples", "u"];

/// What a file describes.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Surface,
    Curve,
}

const KINDS: &[(&str, Kind)] = &[("surface", Kind::Surface), ("curve", Kind::Curve)];
const SCHEMES: &[(&str, Scheme)] = &[
    ("doo-sabin", Scheme::DooSabin),
    ("catmull-clark", Scheme::CatmullClark),
    ("kobbelt", Scheme::Kobbelt),
];
/// Rules of curves; the tension comes beside.
const RULES: &[(&str, Option<Rule>)] = &[
    ("chaikin", Some(Rule::Chaikin)),
    ("cubic", Some(Rule::Cubic)),
    ("four-point", Some(Rule::FourPoint { w: 1.0 })),
    ("qi", None),
];
const ENDS: &[(&str, Ends)] = &[("natural", Ends::Natural), ("clamped", Ends::Clamped)];
const KNOTS: &[(&str, Knots)] = &[("clamped", Knots::Clamped), ("uniform", Knots::Uniform)];
const BLENDS: &[(&str, Blend)] = &[("pairs", Blend::Pairs), ("mean", Blend::Mean)];
const INTEGRATIONS: &[(&str, Integration)] =
    &[("midpoint", Integration::Midpoint), ("arcs", Integration::Arcs)];

pub(super) fn contents(root: &Node) -> Read<Contents> {
    let root = At::root(root);
    match (root.field("fairform"), root.field("model")) {
        // A project of the studio.
        (Some(_), Some(model)) => file(&model),
        _ => file(&root),
    }
}

fn file(root: &At) -> Read<Contents> {
    if root.field("patches").is_some() {
        return patches(root).map(Contents::Surface);
    }
    if root.field("spec").is_some() {
        // A reference value: what was computed from it does not matter here.
        let file = root.object(&[&["kind", "spec", "result"]])?;
        let kind = file.get("kind", |at| at.choice(KINDS))?;
        return file.need("spec", |at| single(at, kind));
    }
    single(root, None)
}

fn single(at: &At, kind: Option<Kind>) -> Read<Contents> {
    let said = field(at, "kind", |at| at.choice(KINDS))?;
    let words = SCHEMES.iter().map(|s| (s.0, Kind::Surface));
    let words: Vec<_> = words.chain(RULES.iter().map(|r| (r.0, Kind::Curve))).collect();
    let guessed = || Ok(field(at, "scheme", |at| at.choice(&words))?.unwrap_or(Kind::Surface));
    Ok(match said.or(kind).map_or_else(guessed, Ok)? {
        Kind::Surface => {
            Contents::Surface(Models { patches: vec![patch(at)?], ..Models::default() })
        }
        Kind::Curve => Contents::Curve(curve(at)?),
    })
}

/// A field of what may be an object, before all of its fields are known.
fn field<T>(at: &At, name: &str, read: impl Fn(&At) -> Read<T>) -> Read<Option<T>> {
    at.field(name).map(|at| read(&at)).transpose()
}

fn patches(root: &At) -> Read<Models> {
    let file = root.object(&[HEAD, &["patches", "stitch"]])?;
    let (name, display) = head(&file, Kind::Surface)?;
    let patches = file.need("patches", |at| at.list("models", patch))?;
    if patches.is_empty() {
        return Err(file.error("patches", "an empty list").expected("one model at least"));
    }
    let stitch = file.get("stitch", stitch)?.unwrap_or_default();
    Ok(Models { name, display, patches, stitch })
}

fn stitch(at: &At) -> Read<Stitch> {
    match (flag(at), text(at).as_deref()) {
        (Ok(true), _) => Ok(Stitch::Shared),
        (Ok(false), _) => Ok(Stitch::None),
        (_, Ok("smooth")) => Ok(Stitch::Smooth),
        _ => Err(at.not("true, false or \"smooth\"")),
    }
}

/// Version and kind, which must be right, then name and display.
fn head(file: &Object, kind: Kind) -> Read<(Option<String>, Option<serde_json::Value>)> {
    file.get("version", |at| {
        let version = number(at)?;
        if version == f64::from(VERSION) {
            return Ok(());
        }
        Err(at
            .error(format_args!("{version}"))
            .expected(format!("{VERSION}, the version that this program knows")))
    })?;
    file.get("kind", |at| match at.choice(KINDS)? {
        said if said == kind => Ok(()),
        _ => Err(at.error("\"curve\"").expected("\"surface\"")),
    })?;
    let name = file.get("name", text)?;
    Ok((name, file.get("display", kept)?))
}

fn patch(at: &At) -> Read<Patch> {
    let file = at.object(&[HEAD, SURFACE])?;
    let (name, display) = head(&file, Kind::Surface)?;
    let tangents = file.need("tangents", |at| {
        at.list("streamlines, each a list of tangents [x, y, z]", |row| {
            row.list("tangents [x, y, z]", unit)
        })
    })?;
    let tangents = rectangle(&file, "tangents", tangents)?;
    let model = Model {
        s: parameters(&file, &tangents)?,
        start: start(&file)?,
        length: file.get("length", length_function)?,
        scheme: file.get("scheme", |at| at.choice(SCHEMES))?.unwrap_or(Scheme::Kobbelt),
        order: file
            .get("order", |at| at.choice(&[("st", Order::St), ("ts", Order::Ts)]))?
            .unwrap_or_default(),
        ends: file.get("ends", |at| at.choice(ENDS))?.unwrap_or_default(),
        w: file.get("w", tension)?.unwrap_or(1.0),
        blend: file.get("blend", |at| at.choice(BLENDS))?.unwrap_or_default(),
        integration: file.get("integration", |at| at.choice(INTEGRATIONS))?.unwrap_or_default(),
        details: file.get("details", |at| at.list("details", detail))?.unwrap_or_default(),
        depth: depth(&file)?,
        ..Model::new(tangents, &[], file.need("t", numbers)?, file.need("initial", initial)?)
    };
    model.check().map_err(|error| located(at, &error))?;
    Ok(Patch { model, name, display })
}

fn depth(file: &Object) -> Read<u32> {
    const DEFAULT: u32 = 3;
    Ok(file.get("depth", |at| at.whole(0, MAX_DEPTH))?.unwrap_or(DEFAULT))
}

fn tension(at: &At) -> Read<f64> {
    let w = number(at)?;
    if w > -8.0 { Ok(w) } else { Err(at.error(w).expected("a tension above -8")) }
}

/// The rows as a grid, if they have one length.
fn rectangle<T>(file: &Object, name: &str, rows: Vec<Vec<T>>) -> Read<Grid<T>> {
    let first = rows.first().map_or(0, Vec::len);
    if first == 0 {
        return Err(file.error(name, "an empty grid").expected("one row of one at least"));
    }
    if let Some(row) = rows.iter().position(|row| row.len() != first) {
        let message = format!("a list of {}", rows[row].len());
        let expected = format!("{first}, as in the first row");
        return Err(file.error(&format!("{name}[{row}]"), message).expected(expected));
    }
    Ok(Grid::from_rows(rows).expect("rows of one length"))
}

/// Arc-length parameters, given or from lengths.
fn parameters(file: &Object, tangents: &Grid<Vec3>) -> Read<Grid<f64>> {
    let (rows, columns) = (tangents.row_count(), tangents.column_count());
    let count = |name: &str, count: usize, expected: usize, what: &str| {
        let wrong = || file.error(name, format_args!("a list of {count}"));
        if count == expected {
            Ok(())
        } else {
            Err(wrong().expected(format!("{expected}, {what}")))
        }
    };
    let per_row = "one for each row of tangents";
    let s = file.get("s", |at| at.list("rows of numbers", numbers))?;
    let lengths = file.get("lengths", |at| at.list("numbers", positive))?;
    match (s, lengths) {
        (Some(_), Some(_)) => {
            Err(file.error("lengths", "is there beside s").expected("only one of the two"))
        }
        (None, None) => Err(file.at.error("no field s or lengths")),
        (Some(s), None) => {
            count("s", s.len(), rows, per_row)?;
            for (k, row) in s.iter().enumerate() {
                count(&format!("s[{k}]"), row.len(), columns, "one for each tangent of the row")?;
            }
            rectangle(file, "s", s)
        }
        (None, Some(lengths)) => {
            count("lengths", lengths.len(), rows, per_row)?;
            Ok(spaced(&lengths, columns))
        }
    }
}

/// The place of the initial curve on the streamlines.
fn start(file: &Object) -> Read<Start> {
    let read = |at: &At| match at.node {
        Node::Number(x) => Ok(Start::At(*x)),
        Node::Object(_) => {
            at.object(&[&["fraction"]])?.need("fraction", number).map(Start::Fraction)
        }
        _ => at
            .choice(&[("min", Start::Min), ("max", Start::Max)])
            .map_err(|e| e.expected("\"min\", \"max\", a number, or {\"fraction\": a number}")),
    };
    Ok(file.get("s0", read)?.unwrap_or_default())
}

fn order(at: &At) -> Read<usize> {
    at.whole(1, MAX_ORDER).map(|n| n as usize)
}

fn initial(at: &At) -> Read<InitialCurve> {
    const TYPES: &[(&str, u8)] = &[("polyline", 0), ("bspline", 1), ("nurbs", 2), ("qi", 3)];
    let Some(kind) = field(at, "type", |at| at.choice(TYPES))? else {
        let all = ["type", "points", "t", "degree", "t0", "t1", "weights", "knots", "tangents"];
        at.object(&[&all, QI])?;
        return Err(at.error("no field type").expected("polyline, bspline, nurbs or qi"));
    };
    match kind {
        0 => {
            let curve = at.object(&[&["type", "points", "t"]])?;
            Ok(InitialCurve::Polyline {
                points: curve.need("points", points)?,
                t: curve.need("t", numbers)?,
            })
        }
        3 => {
            let known = ["type", "tangents", "order", "knots", "length", "start", "t0", "t1"];
            let curve = at.object(&[&known])?;
            Ok(InitialCurve::Qi {
                tangents: curve.need("tangents", directions)?,
                order: curve.need("order", order)?,
                knots: curve.get("knots", |at| at.choice(KNOTS))?.unwrap_or_default(),
                length: curve.need("length", positive)?,
                start: curve.get("start", vector)?.unwrap_or(Vec3::ZERO),
                t0: curve.need("t0", number)?,
                t1: curve.need("t1", number)?,
            })
        }
        rational => {
            let known: &[&[&str]] =
                &[&["type", "points", "degree", "knots", "t0", "t1"], &["weights"]];
            let curve = at.object(&known[..rational as usize])?;
            let weights = |at: &At| at.list("numbers", positive);
            Ok(InitialCurve::Bspline {
                points: curve.need("points", points)?,
                weights: match rational {
                    1 => None,
                    _ => Some(curve.need("weights", weights)?),
                },
                degree: curve.need("degree", order)?,
                knots: curve.get("knots", numbers)?,
                t0: curve.need("t0", number)?,
                t1: curve.need("t1", number)?,
            })
        }
    }
}

/// Vectors of which only the direction counts.
fn directions(at: &At) -> Read<Vec<Vec3>> {
    at.list("directions [x, y, z]", |at| {
        let vector = vector(at)?;
        if vector.normalized().length() > 0.5 {
            return Ok(vector);
        }
        Err(at.error("no direction, for it has no length").expected("a vector that is not zero"))
    })
}

fn length_function(at: &At) -> Read<LengthFunction> {
    const TYPES: &[(&str, bool)] = &[("polyline", false), ("bspline", true)];
    let lengths = |at: &At| at.list("numbers", positive);
    let Some(spline) = field(at, "type", |at| at.choice(TYPES))? else {
        at.object(&[&["type", "lengths", "t", "degree", "t0", "t1"]])?;
        return Err(at.error("no field type").expected("polyline or bspline"));
    };
    if spline {
        let curve = at.object(&[&["type", "lengths", "degree", "t0", "t1"]])?;
        return Ok(LengthFunction::Bspline {
            lengths: curve.need("lengths", lengths)?,
            degree: curve.need("degree", order)?,
            t0: curve.need("t0", number)?,
            t1: curve.need("t1", number)?,
        });
    }
    let curve = at.object(&[&["type", "lengths", "t"]])?;
    Ok(LengthFunction::Polyline {
        lengths: curve.need("lengths", lengths)?,
        t: curve.need("t", numbers)?,
    })
}

fn detail(at: &At) -> Read<Detail> {
    let detail = at.object(&[&["level", "row", "column", "predicted", "tangent"]])?;
    let index = |at: &At| at.whole(0, u32::MAX).map(|n| n as usize);
    Ok(Detail {
        level: detail.need("level", |at| at.whole(1, MAX_DEPTH))?,
        row: detail.need("row", index)?,
        column: detail.need("column", index)?,
        predicted: detail.need("predicted", unit)?,
        tangent: detail.need("tangent", unit)?,
    })
}

fn curve(at: &At) -> Read<Curve> {
    let rule = at.field("scheme").ok_or_else(|| at.error("no field scheme"))?.choice(RULES)?;
    let Some(rule) = rule else { return qi(at) };
    let file = at.object(&[HEAD, CURVE])?;
    head(&file, Kind::Curve)?;
    let w = file.get("w", tension)?;
    let ends = file.get("ends", |at| at.choice(ENDS))?.unwrap_or_default();
    let closed = file.get("closed", flag)?.unwrap_or(false);
    let curve = streamline::Curve {
        tangents: file.need("tangents", |at| at.list("tangents [x, y, z]", unit))?,
        s: file.get("s", numbers)?,
        rule: match (rule, w) {
            (Rule::FourPoint { .. }, Some(w)) => Rule::FourPoint { w },
            (rule, _) => rule,
        },
        ends: if closed { Ends::Closed } else { ends },
        blend: file.get("blend", |at| at.choice(BLENDS))?.unwrap_or_default(),
        start: start(&file)?,
        at: file.get("start", vector)?.unwrap_or(Vec3::ZERO),
        integration: file.get("integration", |at| at.choice(INTEGRATIONS))?.unwrap_or_default(),
        depth: depth(&file)?,
    };
    if closed && curve.s.is_some() {
        let message = "has no meaning where the tangents are closed";
        return Err(file.error("s", message).expected("no s, or no closed"));
    }
    curve.check().map_err(|error| located(at, &error))?;
    Ok(Curve::Subdivided(curve))
}

fn qi(at: &At) -> Read<Curve> {
    let file = at.object(&[HEAD, QI])?;
    head(&file, Kind::Curve)?;
    let samples = file.get("samples", |at| at.whole(2, MAX_SAMPLES))?;
    let u = file.get("u", numbers)?;
    let u = match (samples, u) {
        (Some(_), Some(_)) => {
            return Err(file.error("samples", "is there beside u").expected("only one of the two"));
        }
        (None, None) => return Err(at.error("no field samples or u")),
        (None, Some(u)) => u,
        (Some(n), None) => (0..n).map(|i| f64::from(i) / f64::from(n - 1)).collect(),
    };
    if u.len() > MAX_SAMPLES as usize {
        return Err(file.error("u", format_args!("more than {MAX_SAMPLES} numbers")));
    }
    let in_range = |i: &usize| (if *i == 0 { 0.0 } else { u[i - 1] }..=1.0).contains(&u[*i]);
    if let Some(i) = (0..u.len()).find(|i| !in_range(i)) {
        let error = file.error(&format!("u[{i}]"), u[i]);
        return Err(error.expected("numbers from 0 to 1, none below the one before"));
    }
    let tangents = file.need("tangents", directions)?;
    let order = file.need("order", order)?;
    if order > tangents.len() {
        let expected = format!("at most {}, the number of tangents", tangents.len());
        return Err(file.error("order", order).expected(expected));
    }
    Ok(Curve::Qi {
        tangents,
        order,
        knots: file.get("knots", |at| at.choice(KNOTS))?.unwrap_or_default(),
        length: file.need("length", positive)?,
        start: file.get("start", vector)?.unwrap_or(Vec3::ZERO),
        u,
    })
}

/// An error of the kernel, at the path of its field.
fn located(at: &At, error: &streamline::Error) -> ParseError {
    use streamline::Error as E;
    let increasing = |field: String, index: usize| {
        let message = if index == 0 { "not finite" } else { "not above the number before" };
        ParseError::file(format!("{}: {message}", at.path(&field)))
    };
    match error {
        E::NotIncreasing { level: 0, row, column } => {
            let is_curve = matches!(at.field("s").map(|s| s.node), Some(Node::List(list))
                if matches!(list.first(), Some(Node::Number(_))));
            let field =
                if is_curve { format!("s[{column}]") } else { format!("s[{row}][{column}]") };
            increasing(field, *column)
        }
        E::TNotIncreasing { index } => increasing(format!("t[{index}]"), *index),
        // These begin with the name of their field.
        error => ParseError::file(format!("{}{error}", at.prefix())),
    }
}
