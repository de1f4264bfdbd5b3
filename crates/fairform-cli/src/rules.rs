//! The subdivision rules that the options ask for, on the mesh at hand.

use std::path::Path;
use std::sync::Arc;

use fairform::select::{Context, Labels, Selection, blend, falloff};
use fairform::{Border, Corners, Creases, Rules, Scheme};
use fairform_io::project::{Design, MeshPart};
use fairform_io::{CreaseList, InterpolateBoundary};
use serde_json::Value;

use crate::args::{BorderChoice, CornerChoice, Fit, RuleOptions, TensionOptions};
use crate::console::{Console, count};
use crate::failure::Failure;
use crate::surface::Surface;

/// Gives a surface its rules, and says what they may do to it.
pub(crate) fn set(
    scheme: Scheme,
    options: &RuleOptions,
    surface: &mut Surface,
    console: &Console,
) -> Result<(), Failure> {
    choose(scheme, options, surface)?.iter().for_each(|note| console.note(note));
    Ok(())
}

/// Gives a surface the rules of a project; the command line may choose another scheme, and no more.
pub(crate) fn design(
    part: &MeshPart,
    args: &Fit,
    surface: &mut Surface,
    console: &Console,
) -> Result<(), Failure> {
    let tension = args.rules.tension.is_given().then_some("--lambda and --tension-where");
    if let Some(name) = args.rules.made().or(tension) {
        return Err(Failure::usage(format!("{name}: the project says that of its mesh"))
            .help("change it in the studio, or save the mesh there and fit that"));
    }
    let design = Design { scheme: args.scheme.chosen(), ..part.design.clone() };
    let at = |e| Failure::new(format!("the project's {e}"));
    let (rules, notes) = design.rules(&surface.mesh, surface.creases.as_ref()).map_err(at)?;
    notes.iter().for_each(|note| console.note(format!("note: {note}")));
    surface.rules = rules;
    Ok(())
}

/// Gives a surface its rules. Returns what is to be said about them.
pub(crate) fn choose(
    scheme: Scheme,
    options: &RuleOptions,
    surface: &mut Surface,
) -> Result<Vec<String>, Failure> {
    let mut notes = Vec::new();
    let mut rules = Rules::from(scheme);
    let list = list_of(scheme, options, surface, &mut notes)?;
    let said = list.as_ref().and_then(|list| list.boundary);
    rules.corners = match (options.corners, said) {
        (Some(CornerChoice::Sharp), _) | (None, Some(InterpolateBoundary::EdgeAndCorner)) => {
            Corners::Sharp
        }
        (Some(CornerChoice::Smooth), _) | (None, Some(_)) => Corners::Smooth,
        (None, None) => rules.corners,
    };
    rules.border = match (options.boundary, said) {
        (Some(BorderChoice::Drop), _) => Border::Drop,
        (Some(BorderChoice::None), _) | (None, Some(InterpolateBoundary::None)) => Border::None,
        (Some(BorderChoice::Bspline) | None, _) => Border::Bspline,
    };
    if let Some(w) = options.w {
        rules.kobbelt_weight = w;
    }
    rules.tension = tension(&options.tension, surface)?.map(Into::into);
    if options.tension.lambda.as_deref() == Some("auto") && rules.scheme != Scheme::DooSabin {
        return Err(Failure::new(format!(
            "--lambda auto is for --scheme doo-sabin, not {}: it finds parameters up to 0.5",
            rules.scheme
        )));
    }
    rules.creases = creases_of(options, list.as_ref(), surface)?;
    let topology = surface.mesh.topology();
    notes.extend(rules.warnings(topology).iter().map(|warning| format!("warning: {warning}")));
    let mut has_surface = rules.has_surface(topology);
    for &face in list.iter().flat_map(|list| &list.holes) {
        has_surface[face as usize] = false;
    }
    let support = has_surface.iter().filter(|has| !**has).count();
    if support > 0 {
        let (faces, all) = (count(support), count(has_surface.len()));
        notes.push(match support == has_surface.len() {
            true => "warning: no surface: every face is support, at the boundary or a hole".into(),
            false => {
                format!("note: {faces} of {all} faces are support: the surface ends before them")
            }
        });
        surface.shown = Some(has_surface.into());
    }
    surface.rules = rules;
    Ok(notes)
}

/// One parameter per face, if any option speaks of them.
pub(crate) fn tension(
    options: &TensionOptions,
    surface: &Surface,
) -> Result<Option<Vec<f64>>, Failure> {
    if !options.is_given() {
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

/// The creases that the options or the mesh name, for schemes that know creases.
fn list_of(
    scheme: Scheme,
    options: &RuleOptions,
    surface: &Surface,
    notes: &mut Vec<String>,
) -> Result<Option<CreaseList>, Failure> {
    if let Some(path) = &options.creases {
        if path.as_os_str() == "none" {
            return Ok(None);
        }
        let at = |what: String| Failure::new(format!("{}: {what}", path.display()));
        let bytes = std::fs::read(path).map_err(|e| at(format!("cannot read it: {e}")))?;
        let list = fairform_io::parse_creases(&bytes).map_err(|e| at(e.to_string()))?;
        if list.is_empty() && list.boundary.is_none() {
            return Err(at("no creases in it".into())
                .help("write `t crease 2/1/0 VERTEX VERTEX SHARPNESS` lines, or JSON as in USD"));
        }
        return Ok(Some(list));
    }
    let Some(list) = &surface.creases else { return Ok(None) };
    let counted = |n: usize, one: &str, many: &str| match n {
        0 => None,
        1 => Some(format!("1 {one}")),
        n => Some(format!("{} {many}", count(n))),
    };
    let kept = list.boundary == Some(InterpolateBoundary::EdgeAndCorner);
    let parts = [
        counted(list.edges.len(), "sharp edge", "sharp edges"),
        counted(list.vertices.len(), "sharp vertex", "sharp vertices"),
        counted(list.holes.len(), "hole", "holes"),
        (list.boundary == Some(InterpolateBoundary::None))
            .then(|| "no surface at the boundary".into()),
        kept.then(|| "sharp corners of the boundary".into()),
    ];
    let parts = parts.into_iter().flatten().collect::<Vec<_>>().join(", ");
    let knows_creases = matches!(scheme, Scheme::Loop | Scheme::CatmullClark);
    if !parts.is_empty() {
        notes.push(match knows_creases {
            true => format!("note: from the file: {parts}; --creases none leaves them out"),
            false => format!("note: left out, since {scheme} knows no creases: {parts}"),
        });
    }
    Ok(knows_creases.then(|| list.clone()))
}

/// Sharpness by angle and from a list.
fn creases_of(
    options: &RuleOptions,
    list: Option<&CreaseList>,
    surface: &Surface,
) -> Result<Option<Arc<Creases>>, Failure> {
    let (topology, positions) = (surface.mesh.topology(), surface.mesh.positions());
    let mut creases = match options.crease_angle {
        None => Creases::smooth(topology),
        Some(degrees) => {
            let sharp = fairform::crease::INFINITE;
            Creases::by_angle(topology, positions, degrees, sharp)
                .map_err(|e| Failure::new(format!("--crease-angle: {e}")))?
        }
    };
    if let Some(list) = list {
        let at = |what: String| match &options.creases {
            Some(path) => Failure::new(format!("{}: {what}", path.display())),
            None => Failure::new(format!("the creases of the file: {what}"))
                .help("--creases none leaves them out"),
        };
        list.apply(topology, &mut creases).map_err(at)?;
    }
    Ok((!creases.is_smooth()).then(|| Arc::new(creases)))
}
