//! The subdivision rules that the options ask for, on the mesh at hand.

use std::path::Path;
use std::sync::Arc;

use fairform::select::{Context, Labels, Selection, blend, falloff};
use fairform::{Border, Corners, Creases, Rules, Scheme};
use serde_json::Value;

use crate::args::{BorderChoice, CornerChoice, RuleOptions, TensionOptions};
use crate::console::Console;
use crate::failure::Failure;
use crate::surface::Surface;

/// The rules for a surface, with warnings of what they may do to it.
pub(crate) fn build(
    options: &RuleOptions,
    surface: &Surface,
    console: &Console,
) -> Result<Rules, Failure> {
    let mut rules = Rules {
        scheme: options.scheme,
        corners: match options.corners {
            Some(CornerChoice::Sharp) => Corners::Sharp,
            None if options.scheme == Scheme::Kobbelt => Corners::Sharp,
            Some(CornerChoice::Smooth) | None => Corners::Smooth,
        },
        kobbelt_weight: options.w,
        border: match options.boundary {
            BorderChoice::Bspline => Border::Bspline,
            BorderChoice::Drop => Border::Drop,
        },
        ..Rules::LOOP
    };
    rules.tension = tension(&options.tension, surface)?.map(Into::into);
    if options.tension.lambda.as_deref() == Some("auto") && rules.scheme != Scheme::DooSabin {
        return Err(Failure::new(format!(
            "--lambda auto is for --scheme doo-sabin, not {}: it finds parameters up to 0.5",
            rules.scheme
        )));
    }
    creases_of(options, surface, &mut rules)?;
    for warning in rules.warnings(surface.mesh.topology()) {
        console.note(format!("warning: {warning}"));
    }
    Ok(rules)
}

/// One parameter per face, if any option speaks of them.
pub(crate) fn tension(
    options: &TensionOptions,
    surface: &Surface,
) -> Result<Option<Vec<f64>>, Failure> {
    if options.lambda.is_none() && options.tension_where.is_empty() {
        return Ok(None);
    }
    let count = surface.mesh.topology().face_count();
    let mut tension = match options.lambda.as_deref() {
        None => vec![0.5; count],
        Some("auto") => fairform::tension::automatic(&surface.mesh),
        Some(text) => match text.parse::<f64>() {
            Ok(one) => vec![one; count],
            Err(_) => from_file(Path::new(text), count)?,
        },
    };
    let mut context = Context::new(&surface.mesh);
    context.groups = surface.groups.as_ref().map(|l| Labels::new(&l.names, &l.of_face));
    context.materials = surface.materials.as_ref().map(|l| Labels::new(&l.names, &l.of_face));
    for (text, value) in &options.tension_where {
        let at = |e: &dyn std::fmt::Display| Failure::new(format!("--tension-where {text:?}: {e}"));
        let selection: Selection = text.parse().map_err(|e| at(&e))?;
        let selected = selection.faces(&context).map_err(|e| at(&e))?;
        let weight = match options.falloff {
            Some(distance) => falloff(&surface.mesh, &selected, distance).map_err(|e| at(&e))?,
            None => selected.iter().map(|&s| f64::from(u8::from(s))).collect(),
        };
        blend(&mut tension, &weight, *value);
    }
    Ok(Some(tension))
}

/// A number for all faces, a list of one per face, or a default with exceptions by face number.
fn from_file(path: &Path, count: usize) -> Result<Vec<f64>, Failure> {
    let at = |what: String| {
        Failure::new(format!("{}: {what}", path.display())).help(
            "--lambda takes a number, auto, or a JSON file: a number, a list of one per face, or \
             {\"default\": 0.5, \"faces\": {\"3\": 0.8}}",
        )
    };
    let text = std::fs::read_to_string(path).map_err(|e| at(format!("cannot read it: {e}")))?;
    let value: Value = serde_json::from_str(&text).map_err(|e| at(e.to_string()))?;
    let number = |value: &Value, what: &str| {
        value.as_f64().ok_or_else(|| at(format!("{what} is {value}, not a number")))
    };
    match &value {
        Value::Number(_) => Ok(vec![number(&value, "the value")?; count]),
        Value::Array(list) if list.len() == count => {
            (0..).zip(list).map(|(f, v)| number(v, &format!("the value of face {f}"))).collect()
        }
        Value::Array(list) => {
            Err(at(format!("{} values, but the mesh has {count} faces", list.len())))
        }
        Value::Object(object) => {
            let unknown = object.keys().find(|key| !["default", "faces"].contains(&key.as_str()));
            if let Some(key) = unknown {
                return Err(at(format!("unknown field {key:?}")));
            }
            let default = object.get("default").map_or(Ok(0.5), |v| number(v, "the default"))?;
            let mut tension = vec![default; count];
            let faces = object.get("faces").and_then(Value::as_object);
            for (key, value) in faces.into_iter().flatten() {
                let face: Option<usize> = key.parse().ok();
                let slot = face.and_then(|f| tension.get_mut(f));
                let slot = slot.ok_or_else(|| {
                    at(format!("there is no face {key:?}; the mesh has {count} faces, from 0"))
                })?;
                *slot = number(value, &format!("the value of face {key}"))?;
            }
            Ok(tension)
        }
        _ => Err(at("neither a number, a list nor an object".into())),
    }
}

fn creases_of(options: &RuleOptions, surface: &Surface, rules: &mut Rules) -> Result<(), Failure> {
    if options.creases.is_none() && options.crease_angle.is_none() {
        return Ok(());
    }
    let (topology, positions) = (surface.mesh.topology(), surface.mesh.positions());
    let mut creases = Creases::smooth(topology);
    if let Some(degrees) = options.crease_angle {
        let sharp = fairform::crease::INFINITE;
        creases = Creases::by_angle(topology, positions, degrees, sharp)
            .map_err(|e| Failure::new(format!("--crease-angle: {e}")))?;
    }
    if let Some(path) = &options.creases {
        let at = |what: String| Failure::new(format!("{}: {what}", path.display()));
        let bytes = std::fs::read(path).map_err(|e| at(format!("cannot read it: {e}")))?;
        let list = fairform_io::parse_creases(&bytes).map_err(|e| at(e.to_string()))?;
        if list.is_empty() && list.keep_corners.is_none() {
            return Err(at("no creases in it".into())
                .help("write `t crease 2/1/0 VERTEX VERTEX SHARPNESS` lines, or JSON as in USD"));
        }
        list.apply(topology, &mut creases).map_err(at)?;
        if list.keep_corners == Some(true) {
            rules.corners = Corners::Sharp;
        }
    }
    if !creases.is_smooth() {
        rules.creases = Some(Arc::new(creases));
    }
    Ok(())
}
