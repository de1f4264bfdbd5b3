//! B-spline surfaces as free-form surfaces of OBJ.

use std::fmt::Write;

use fairform::streamline::BsplineSurface;

use crate::obj::statement_name;

/// Numbers on a line; longer statements go on behind a backslash.
const PER_LINE: usize = 12;

pub(super) fn obj(surfaces: &[(&str, &BsplineSurface)]) -> String {
    let mut out = String::new();
    let mut first = 1;
    for (name, surface) in surfaces {
        for p in surface.points.values() {
            let _ = writeln!(out, "v {} {} {}", p.x, p.y, p.z);
        }
        let name = statement_name(name);
        if !name.is_empty() {
            let _ = writeln!(out, "g {name}");
        }
        out += "cstype bspline\ndeg 3 3\n";
        // The control points with u, along the rows, running fastest.
        let count = surface.points.values().len();
        statement(&mut out, "surf 0 1 0 1", first..first + count);
        let [along, across] = surface.knots();
        statement(&mut out, "parm u", along);
        statement(&mut out, "parm v", across);
        out += "end\n";
        first += count;
    }
    out
}

fn statement<T: std::fmt::Display>(
    out: &mut String,
    head: &str,
    list: impl IntoIterator<Item = T>,
) {
    *out += head;
    for (i, one) in list.into_iter().enumerate() {
        if i > 0 && i.is_multiple_of(PER_LINE) {
            *out += " \\\n ";
        }
        let _ = write!(out, " {one}");
    }
    *out += "\n";
}
