//! `fairform curve`.

use std::path::Path;
use std::process::ExitCode;

use fairform::Vec3;
use fairform::scheme::kobbelt;
use fairform::sphere::{self, QiCurve, Rule};
use fairform::streamline::{self, Warning};
use fairform_io::streamline::{Curve, read_curve};
use serde_json::{Value, json};

use crate::args;
use crate::console::{Console, count};
use crate::failure::Failure;
use crate::input::{self, Source};
use crate::models;

pub(crate) fn run(args: &args::Curve, console: &Console) -> Result<ExitCode, Failure> {
    let as_polyline = args.output.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj"));
    if !as_polyline && !input::is_json(&args.output) && !input::is_dash(&args.output) {
        let name = args.output.display();
        return Err(Failure::usage(format!("{name}: the name tells no format"))
            .help("end it in .json or .obj"));
    }
    input::check_outputs(&[&args.output], console)?;
    let source = Source { path: &args.input, format: None };
    let mut curve = read_curve(&args.input)?;
    if let Some(depth) = args.depth {
        match &mut curve {
            Curve::Subdivided(curve) => curve.depth = depth,
            Curve::Qi { .. } => {
                return Err(Failure::usage("--depth is for curves by subdivision")
                    .help("a QI curve says in its file how many points it has: samples or u"));
            }
        }
    }
    warn(&curve, &source, console);
    let made = Made::new(curve).map_err(|e| Failure::new(format!("{source}: {e}")))?;
    if as_polyline {
        if made.points.is_empty() {
            return Err(Failure::new(format!("{source}: has tangents, but no points"))
                .help("give s, the arc-length parameter of each tangent"));
        }
        input::save(&args.output, polyline(&made.points).as_bytes())?;
    } else {
        input::save(&args.output, made.json().to_string().as_bytes())?;
    }
    report(&made, &args.output, console)
}

fn report(made: &Made, output: &Path, console: &Console) -> Result<ExitCode, Failure> {
    let (tangents, points) = (made.tangents.len(), made.points.len());
    console.detail(format!(
        "{}: {} tangents, {} points",
        output.display(),
        count(tangents),
        count(points)
    ));
    console.result(&json!({ "tangents": tangents, "points": points }))?;
    Ok(ExitCode::SUCCESS)
}

fn warn(curve: &Curve, source: &Source, console: &Console) {
    let tangents = match curve {
        Curve::Subdivided(curve) => {
            if let Rule::FourPoint { w } = curve.rule
                && !(w > 0.0 && w < kobbelt::SMOOTH_BELOW)
            {
                models::warn(source, &Warning::Tension { w }, console);
            }
            &curve.tangents
        }
        Curve::Qi { tangents, .. } => tangents,
    };
    for i in sphere::antipodal_neighbours(tangents) {
        console.note(format!(
            "warning: {source}: tangents {i} and {} are opposite: any turn between them is as good, \
             so one is chosen",
            i + 1
        ));
    }
}

/// What a curve becomes; lists that it has not are empty.
#[derive(Default)]
struct Made {
    u: Vec<f64>,
    s: Vec<f64>,
    tangents: Vec<Vec3>,
    points: Vec<Vec3>,
}

impl Made {
    fn new(curve: Curve) -> Result<Self, streamline::Error> {
        match curve {
            Curve::Subdivided(curve) => {
                let made = curve.refine()?;
                Ok(Self { s: made.s, tangents: made.tangents, points: made.points, u: vec![] })
            }
            Curve::Qi { tangents, order, knots, length, start, u } => {
                let made = QiCurve::new(&tangents, order, knots)
                    .and_then(|curve| curve.points(length, start, &u));
                let field = "tangents";
                let (points, tangents) =
                    made.map_err(|error| streamline::Error::Sphere { field, error })?;
                Ok(Self { u, tangents, points, s: vec![] })
            }
        }
    }

    fn json(&self) -> Value {
        let mut result = json!({ "tangents": models::vectors(&self.tangents) });
        for (name, numbers) in [("u", &self.u), ("s", &self.s)] {
            if !numbers.is_empty() {
                result[name] = json!(numbers);
            }
        }
        if !self.points.is_empty() {
            result["points"] = models::vectors(&self.points);
        }
        result
    }
}

/// Points in one line element.
fn polyline(points: &[Vec3]) -> String {
    let mut text: String =
        points.iter().map(|p| format!("v {:?} {:?} {:?}\n", p.x, p.y, p.z)).collect();
    text += "l";
    text.extend((1..=points.len()).map(|i| format!(" {i}")));
    text.push('\n');
    text
}
