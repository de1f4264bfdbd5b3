//! Models and curves as text.

use fairform::Vec3;
use fairform::sphere::{Blend, Ends, Knots, Rule};
use fairform::streamline::{
    self, Detail, Grid, InitialCurve, Integration, LengthFunction, Model, Order, Start, spaced,
};
use serde_json::{Value, json};

use super::{Curve, Models, Patch, Stitch, VERSION};
use crate::error::Error;

type Fields = Vec<(&'static str, Value)>;

/// An object, field by field, each on a line of its own; lists of rows have a line for each row.
struct Object {
    text: String,
    indent: &'static str,
}

impl Object {
    fn new(indent: &'static str) -> Self {
        Self { text: "{".into(), indent }
    }

    fn key(&mut self, name: &str) {
        let comma = if self.text.len() > 1 { "," } else { "" };
        self.text += &format!("{comma}\n{}  \"{name}\": ", self.indent);
    }

    fn field(&mut self, name: &str, value: &Value) {
        self.key(name);
        self.text += &spread(value);
    }

    fn field_if(&mut self, name: &str, value: Option<Value>) {
        if let Some(value) = value {
            self.field(name, &value);
        }
    }

    /// An object on one line, its fields in the order given.
    fn inline(&mut self, name: &str, fields: &Fields) {
        self.key(name);
        let field = |(name, value): &(&str, Value)| format!("\"{name}\": {}", spread(value));
        self.text += &format!("{{{}}}", fields.iter().map(field).collect::<Vec<_>>().join(", "));
    }

    fn rows(&mut self, name: &str, rows: impl Iterator<Item = Value>) {
        self.key(name);
        let separator = format!(",\n{}    ", self.indent);
        let rows: Vec<_> = rows.map(|row| spread(&row)).collect();
        self.text += &format!("[{}{}\n{}  ]", &separator[1..], rows.join(&separator), self.indent);
    }

    fn end(mut self) -> String {
        self.text += &format!("\n{}}}", self.indent);
        self.text
    }
}

/// A value on one line, with blanks behind commas and colons.
fn spread(value: &Value) -> String {
    match value {
        Value::Array(list) => {
            format!("[{}]", list.iter().map(spread).collect::<Vec<_>>().join(", "))
        }
        Value::Object(fields) => {
            let field = |(name, value): (&String, &Value)| {
                format!("{}: {}", Value::from(name.as_str()), spread(value))
            };
            format!("{{{}}}", fields.iter().map(field).collect::<Vec<_>>().join(", "))
        }
        // Whole numbers as people write them; the sign of zero is kept.
        Value::Number(x) => {
            let text = x.to_string();
            text.strip_suffix(".0").map_or(text.clone(), |whole| match whole {
                "-0" => text.clone(),
                whole => whole.into(),
            })
        }
        value => value.to_string(),
    }
}

fn vector(v: Vec3) -> Value {
    json!(<[f64; 3]>::from(v))
}

fn vectors(list: &[Vec3]) -> Value {
    list.iter().map(|&v| vector(v)).collect()
}

fn unwritable(what: &str) -> Error {
    Error::Unwritable(what.into())
}

/// JSON has no place for other numbers.
fn all_finite(finite: bool) -> Result<(), Error> {
    if finite { Ok(()) } else { Err(unwritable("a number of the model is not finite")) }
}

pub(super) fn models(models: &Models) -> Result<String, Error> {
    let plain = models.name.is_none() && models.display.is_none() && models.stitch == Stitch::None;
    if let (true, [patch]) = (plain, &*models.patches) {
        return Ok(self::patch(patch, "")? + "\n");
    }
    if models.patches.is_empty() {
        return Err(unwritable("there is no model to write"));
    }
    let mut file = Object::new("");
    head(&mut file, "surface", models.name.as_deref());
    file.field_if(
        "stitch",
        match models.stitch {
            Stitch::None => None,
            Stitch::Shared => Some(true.into()),
            Stitch::Smooth => Some("smooth".into()),
        },
    );
    file.key("patches");
    let patches: Result<Vec<_>, _> = models.patches.iter().map(|one| patch(one, "    ")).collect();
    file.text += &format!("[\n    {}\n  ]", patches?.join(",\n    "));
    file.field_if("display", models.display.clone());
    Ok(file.end() + "\n")
}

fn head(file: &mut Object, kind: &str, name: Option<&str>) {
    file.field("version", &VERSION.into());
    file.field("kind", &kind.into());
    file.field_if("name", name.map(Value::from));
}

fn patch(patch: &Patch, indent: &'static str) -> Result<String, Error> {
    let model = &patch.model;
    check(model)?;
    let mut file = Object::new(indent);
    head(&mut file, "surface", patch.name.as_deref());
    file.rows("tangents", model.tangents.rows().map(vectors));
    match lengths(&model.s) {
        Some(lengths) => file.field("lengths", &json!(lengths)),
        None => file.rows("s", model.s.rows().map(|row| json!(row))),
    }
    file.field("t", &json!(model.t));
    file.field("scheme", &model.scheme.name().into());
    file.field("order", &if model.order == Order::Ts { "ts" } else { "st" }.into());
    file.field("ends", &ends(model.ends)?.into());
    file.field("w", &json!(model.w));
    file.field("depth", &model.depth.into());
    file.inline("initial", &initial(&model.initial)?);
    file.field("s0", &start(model.start)?);
    if let Some(length) = &model.length {
        file.inline("length", &length_function(length)?);
    }
    integration_and_blend(&mut file, model.integration, model.blend);
    if !model.details.is_empty() {
        file.rows("details", model.details.iter().map(detail));
    }
    file.field_if("display", patch.display.clone());
    Ok(file.end())
}

fn check(model: &Model) -> Result<(), Error> {
    model.rule().map_err(|error| Error::Unwritable(error.to_string()))?;
    all_finite(
        model.tangents.values().iter().all(|t| t.is_finite())
            && model.s.values().iter().chain(&model.t).all(|x| x.is_finite())
            && model.w.is_finite()
            && model.details.iter().all(|d| d.predicted.is_finite() && d.tangent.is_finite()),
    )
}

/// The lengths of which evenly spaced parameters are these, to the last bit.
fn lengths(s: &Grid<f64>) -> Option<Vec<f64>> {
    let columns = s.column_count();
    if columns < 2 {
        return None;
    }
    // Dividing by their number and multiplying may miss the last bit.
    let length = |row: &[f64]| {
        let last = row[columns - 1];
        let near = [last, last.next_up(), last.next_down()];
        near.into_iter()
            .find(|l| *l > 0.0 && l.is_finite() && spaced(&[*l], columns).values() == row)
    };
    s.rows().map(length).collect()
}

fn ends(ends: Ends) -> Result<&'static str, Error> {
    match ends {
        Ends::Natural => Ok("natural"),
        Ends::Clamped => Ok("clamped"),
        Ends::Closed => Err(unwritable("closed ends have no place in a model file")),
    }
}

fn start(start: Start) -> Result<Value, Error> {
    Ok(match start {
        Start::Min => "min".into(),
        Start::Max => "max".into(),
        Start::At(x) => {
            all_finite(x.is_finite())?;
            json!(x)
        }
        Start::Fraction(x) => {
            all_finite(x.is_finite())?;
            json!({ "fraction": x })
        }
    })
}

fn integration_and_blend(file: &mut Object, integration: Integration, blend: Blend) {
    let integration = match integration {
        Integration::Midpoint => "midpoint",
        Integration::Arcs => "arcs",
    };
    file.field("integration", &integration.into());
    file.field("blend", &if blend == Blend::Mean { "mean" } else { "pairs" }.into());
}

fn knots(knots: Knots) -> &'static str {
    match knots {
        Knots::Clamped => "clamped",
        Knots::Uniform => "uniform",
    }
}

fn initial(curve: &InitialCurve) -> Result<Fields, Error> {
    let finite = |points: &[Vec3], numbers: &[f64]| {
        let points = points.iter().all(|p| p.is_finite());
        all_finite(points && numbers.iter().all(|x| x.is_finite()))
    };
    match curve {
        InitialCurve::Polyline { points, t } => {
            finite(points, t)?;
            Ok(vec![("type", "polyline".into()), ("points", vectors(points)), ("t", json!(t))])
        }
        InitialCurve::Bspline { points, weights, degree, knots, t0, t1 } => {
            finite(points, &[*t0, *t1])?;
            finite(&[], weights.as_deref().unwrap_or_default())?;
            finite(&[], knots.as_deref().unwrap_or_default())?;
            let kind = if weights.is_some() { "nurbs" } else { "bspline" };
            let mut fields = vec![("type", kind.into()), ("points", vectors(points))];
            fields.extend(weights.as_ref().map(|list| ("weights", json!(list))));
            fields.push(("degree", json!(degree)));
            fields.extend(knots.as_ref().map(|list| ("knots", json!(list))));
            fields.extend([("t0", json!(t0)), ("t1", json!(t1))]);
            Ok(fields)
        }
        InitialCurve::Qi { tangents, order, knots: places, length, start, t0, t1 } => {
            finite(tangents, &[*length, *t0, *t1])?;
            finite(&[*start], &[])?;
            Ok(vec![
                ("type", "qi".into()),
                ("tangents", vectors(tangents)),
                ("order", json!(order)),
                ("knots", knots(*places).into()),
                ("length", json!(length)),
                ("start", vector(*start)),
                ("t0", json!(t0)),
                ("t1", json!(t1)),
            ])
        }
        _ => Err(unwritable("an initial curve of this kind has no place in a model file")),
    }
}

fn length_function(length: &LengthFunction) -> Result<Fields, Error> {
    let finite = |list: &[f64]| all_finite(list.iter().all(|x| x.is_finite()));
    match length {
        LengthFunction::Polyline { lengths, t } => {
            finite(lengths)?;
            finite(t)?;
            Ok(vec![("type", "polyline".into()), ("lengths", json!(lengths)), ("t", json!(t))])
        }
        LengthFunction::Bspline { lengths, degree, t0, t1 } => {
            finite(lengths)?;
            finite(&[*t0, *t1])?;
            Ok(vec![
                ("type", "bspline".into()),
                ("lengths", json!(lengths)),
                ("degree", json!(degree)),
                ("t0", json!(t0)),
                ("t1", json!(t1)),
            ])
        }
    }
}

fn detail(detail: &Detail) -> Value {
    json!({ "level": detail.level, "row": detail.row, "column": detail.column,
        "predicted": vector(detail.predicted), "tangent": vector(detail.tangent) })
}

pub(super) fn curve(curve: &Curve) -> Result<String, Error> {
    let mut file = Object::new("");
    head(&mut file, "curve", None);
    match curve {
        Curve::Subdivided(curve) => subdivided(&mut file, curve)?,
        Curve::Qi { tangents, order, knots: places, length, start, u } => {
            all_finite(
                tangents.iter().chain([start]).all(|t| t.is_finite())
                    && u.iter().chain([length]).all(|x| x.is_finite()),
            )?;
            file.field("scheme", &"qi".into());
            file.rows("tangents", tangents.iter().map(|&t| vector(t)));
            file.field("order", &json!(order));
            file.field("knots", &knots(*places).into());
            file.field("length", &json!(length));
            file.field("start", &vector(*start));
            file.field("u", &json!(u));
        }
    }
    Ok(file.end() + "\n")
}

fn subdivided(file: &mut Object, curve: &streamline::Curve) -> Result<(), Error> {
    let numbers = curve.s.as_deref().unwrap_or_default();
    all_finite(
        curve.tangents.iter().chain([&curve.at]).all(|t| t.is_finite())
            && numbers.iter().all(|x| x.is_finite()),
    )?;
    file.field("scheme", &curve.rule.name().into());
    file.rows("tangents", curve.tangents.iter().map(|&t| vector(t)));
    match curve.ends {
        Ends::Closed => file.field("closed", &true.into()),
        open => file.field("ends", &ends(open)?.into()),
    }
    if let Rule::FourPoint { w } = curve.rule {
        all_finite(w.is_finite())?;
        file.field("w", &json!(w));
    }
    file.field("depth", &curve.depth.into());
    file.field_if("s", curve.s.as_ref().map(|s| json!(s)));
    file.field("s0", &start(curve.start)?);
    file.field("start", &vector(curve.at));
    integration_and_blend(file, curve.integration, curve.blend);
    Ok(())
}
