//! The selection language says what its table says, names every mistake, and survives any text.

use std::fmt::Write;
use std::time::{Duration, Instant};

use fairform::select::{Context, Labels, SelectError, Selection, blend, falloff, grow, shrink};
use fairform::{Error, FaceId, Faces, Mesh, Vec3, shapes};
use proptest::prelude::*;

// ---------------------------------------------------------------------------------------------
// Helpers

/// The numbers of the faces that a text selects.
#[track_caller]
fn picked(text: &str, context: &Context) -> Vec<usize> {
    let selection: Selection = text.parse().unwrap_or_else(|e| panic!("{text}: {e}"));
    let faces = selection.faces(context).unwrap_or_else(|e| panic!("{text}: {e}"));
    numbers(&faces)
}

fn numbers(faces: &[bool]) -> Vec<usize> {
    (0..faces.len()).filter(|&f| faces[f]).collect()
}

#[track_caller]
fn canonical(text: &str) -> String {
    text.parse::<Selection>().unwrap_or_else(|e| panic!("{text}: {e}")).to_string()
}

/// The error of a text, found while reading it or else on the cube of [`labelled`].
#[track_caller]
fn error(text: &str) -> SelectError {
    labelled(|context| text.parse::<Selection>().and_then(|s| s.faces(context)))
        .expect_err("a mistake")
}

const GROUPS: [&str; 5] = ["", "lid", "blue steel", "rim.001", "a*b:c\"d\\"];

/// Runs on the unit cube, whose faces are z=0, z=1, y=0, y=1, x=0, x=1, with groups
/// `"", lid, blue steel, rim.001, a*b:c"d\, lid` and materials `oak, oak, oak, tin, tin, tin`.
fn labelled<R>(run: impl FnOnce(&Context) -> R) -> R {
    let mesh = shapes::cube();
    run(&Context {
        mesh: &mesh,
        groups: Some(Labels::new(&GROUPS, &[0, 1, 2, 3, 4, 1])),
        materials: Some(Labels::new(&["oak", "tin"].map(String::from), &[0, 0, 0, 1, 1, 1])),
    })
}

#[track_caller]
fn assert_picks(cases: &[(&str, &[usize])]) {
    labelled(|context| {
        for (text, expected) in cases {
            assert_eq!(picked(text, context), *expected, "{text}");
        }
    });
}

// ---------------------------------------------------------------------------------------------
// Each form

#[test]
fn all_none_and_the_boundary() {
    assert_picks(&[("all", &[0, 1, 2, 3, 4, 5]), ("none", &[]), ("boundary", &[])]);
    // In a sheet of 3 × 3 halved squares, the halves that touch the boundary only with a vertex,
    // and those of the middle square, are left out.
    let sheet = shapes::sheet(4, 4, |_, _| 0.0);
    let boundary = picked("boundary", &Context::new(&sheet));
    assert_eq!(boundary, [0, 1, 2, 4, 7, 10, 13, 15, 16, 17]);
}

#[test]
fn names_match_exactly_or_by_pattern() {
    assert_picks(&[
        ("group=lid", &[1, 5]),
        ("group = lid", &[1, 5]),
        ("group=l?d", &[1, 5]),
        ("group=*", &[0, 1, 2, 3, 4, 5]),
        ("group=?*", &[1, 2, 3, 4, 5]),
        ("group=\"\"", &[0]),
        ("group=''", &[0]),
        ("group=*i*", &[1, 3, 5]),
        ("group=*00*1", &[3]),
        ("group=rim.001", &[3]),
        ("group='blue steel'", &[2]),
        ("group=\"blue*\"", &[2]),
        ("group=blue*", &[2]),
        (r#"group="a\*b:c\"d\\""#, &[4]),
        (r#"group='a\*b:c"d\\'"#, &[4]),
        ("group=a*", &[4]),
        ("group=lid,rim*", &[1, 3, 5]),
        ("material=tin", &[3, 4, 5]),
        ("material=?a?,tin", &[0, 1, 2, 3, 4, 5]),
        ("group=lid and material=tin", &[5]),
    ]);
    // Words of the language are names where a name is due.
    let mesh = crate::common::triangle();
    let names = ["not", "and", "all"];
    let context = Context { groups: Some(Labels::new(&names, &[1])), ..Context::new(&mesh) };
    assert_eq!(picked("group=and and not group=not", &context), [0]);
}

#[test]
fn characters_of_any_length_match() {
    let mesh = crate::common::triangle();
    let names = ["Größe–日本"];
    let context = Context { groups: Some(Labels::new(&names, &[0])), ..Context::new(&mesh) };
    for pattern in ["Größe–日本", "Gr??e*", "????????", "*本", "*ö*日*", "**?**"] {
        assert_eq!(picked(&format!("group={pattern}"), &context), [0], "{pattern}");
    }
    for pattern in ["größe–日本", "?????????", "*日", "*本?", "Größe–日本*本"] {
        let error = format!("group={pattern}").parse::<Selection>().unwrap().faces(&context);
        assert!(error.is_err(), "{pattern}");
    }
}

#[test]
fn numbers_are_ranges_with_both_ends() {
    assert_picks(&[
        ("face=0", &[0]),
        ("face=1..3", &[1, 2, 3]),
        ("face=0..1,4", &[0, 1, 4]),
        ("face = 5 , 0 .. 1", &[0, 1, 5]),
        ("face=4..", &[4, 5]),
        ("face=5..5", &[5]),
        ("part=0", &[0, 1, 2, 3, 4, 5]),
        ("corners=4", &[0, 1, 2, 3, 4, 5]),
        ("corners=3", &[]),
        ("corners=3..", &[0, 1, 2, 3, 4, 5]),
        ("corners=0..3,5..", &[]),
    ]);
    let positions = (0..5).map(|i| Vec3::new(f64::from(i), f64::from(i * i), 0.0)).collect();
    let mixed: Faces = [&[0_u32, 1, 2, 3][..], &[0, 3, 4]].into_iter().collect();
    let mixed = Mesh::new(positions, &mixed).unwrap();
    let context = Context::new(&mixed);
    assert_eq!(picked("corners=3", &context), [1]);
    assert_eq!(picked("corners=4..9", &context), [0]);
}

/// The icosahedron has the lower vertices; isolated vertices are no part.
#[test]
fn parts_are_numbered_by_their_lowest_vertex() {
    let several = crate::common::several();
    let context = Context::new(&several);
    assert_eq!(picked("part=0", &context), (0..20).collect::<Vec<_>>());
    assert_eq!(picked("part=1", &context), (20..25).collect::<Vec<_>>());
    assert_eq!(picked("part=0..1", &context).len(), 25);
    assert_eq!(picked("part=1 & part=0", &context), [0; 0]);
    let message = "part=2".parse::<Selection>().unwrap().faces(&context).unwrap_err().to_string();
    assert_eq!(message, "column 6: there is no part 2; expected a part from 0 to 1");

    // The part of the first face need not be the first.
    let points = (0..6).map(|i| Vec3::new(f64::from(i), f64::from(i * i), 0.0)).collect();
    let mesh = Mesh::new(points, &Faces::uniform(3, vec![3, 4, 5, 2, 0, 1])).unwrap();
    assert_eq!(picked("part=0", &Context::new(&mesh)), [1]);
}

#[test]
fn regions_hold_the_centres() {
    assert_picks(&[
        ("z>0.5", &[1]),
        ("z>=0.5", &[1, 2, 3, 4, 5]),
        ("z<0.5", &[0]),
        ("z <= 0.5", &[0, 2, 3, 4, 5]),
        ("x>.9", &[5]),
        ("x<1e-9", &[4]),
        ("y>-1", &[0, 1, 2, 3, 4, 5]),
        ("y<=-0", &[2]),
        ("plane=0,0,1,0.5", &[1]),
        ("plane=0,0,-1,-0.5", &[0]),
        ("plane=1,1,1,1.9", &[1, 3, 5]),
        ("plane=2,2,2,3.9", &[1, 3, 5]),
        ("box=0,0,0..1,1,1", &[0, 1, 2, 3, 4, 5]),
        ("box=0,0,0..1,1,.5", &[0, 2, 3, 4, 5]),
        ("box=1,1,0.5..0,0,0", &[0, 2, 3, 4, 5]),
        ("box = 0.5, 0.5, 0 .. 0.5, 0.5, 0", &[0]),
        ("box=0,0,0.6...9,1,1.", &[1]),
        ("box=0,0,0.6...4,1,1.", &[]),
        ("sphere=0.5,0.5,1,0", &[1]),
        ("sphere=0.5,0.5,1,0.71", &[1, 2, 3, 4, 5]),
        ("sphere=0.5,0.5,0.5,0.5", &[0, 1, 2, 3, 4, 5]),
        ("sphere=.5,.5,.5,.4999", &[]),
    ]);
}

#[test]
fn normals_are_within_their_angle() {
    assert_picks(&[
        ("normal=0,0,1,0", &[1]),
        ("normal=0,0,-2,89", &[0]),
        ("normal=0,0,1,90", &[1, 2, 3, 4, 5]),
        ("normal=0,0,1,180", &[0, 1, 2, 3, 4, 5]),
        ("normal=1,1,1,54.73561031", &[]),
        ("normal=1,1,1,54.7356103172453", &[1, 3, 5]),
        ("normal=1e300,1e300,1e300,55", &[1, 3, 5]),
        ("normal=1e-300,0,0,1", &[5]),
    ]);
    // A face without area has no normal.
    let points = [[0., 0., 0.], [1., 0., 0.], [2., 0., 0.]].map(Vec3::from).to_vec();
    let flat = Mesh::new(points, &Faces::uniform(3, vec![0, 1, 2])).unwrap();
    assert_eq!(picked("normal=0,0,1,180", &Context::new(&flat)), [0; 0]);
}

/// Means and normals stand sizes at which sums and products overflow, and level faces keep their
/// height to the last bit.
#[test]
fn centres_and_normals_are_exact_and_robust() {
    for size in [1e-200, 0.1, 1e154, 1.7e308] {
        let base = shapes::cube();
        let points = base.positions().iter().map(|&p| size * (2.0 * p + Vec3::splat(-1.0)));
        let mesh = base.with_positions(points.collect());
        let context = Context::new(&mesh);
        let number = format!("{size:e}");
        assert_eq!(picked(&format!("z>={number}"), &context), [1], "{size}");
        assert_eq!(picked("z>0", &context), [1], "{size}");
        assert_eq!(picked("normal=0,0,1,1", &context), [1], "{size}");
        assert_eq!(picked(&format!("box=0,0,{number}..0,0,{number}"), &context), [1], "{size}");
    }
    let sheet = shapes::sheet(5, 9, |_, _| 0.1);
    assert_eq!(picked("z<=0.1 & z>=0.1", &Context::new(&sheet)).len(), 64);
}

#[test]
fn a_mesh_without_faces_has_nothing_to_pick() {
    let empty = Mesh::new(vec![Vec3::ZERO], &Faces::new()).unwrap();
    let context = Context::new(&empty);
    for text in ["all", "none", "boundary", "z>0 or not x>0", "corners=3"] {
        assert_eq!(picked(text, &context), [0; 0], "{text}");
    }
    for text in ["face=0", "part=0", "face=0..", "group=lid"] {
        assert!(text.parse::<Selection>().unwrap().faces(&context).is_err(), "{text}");
    }
}

// ---------------------------------------------------------------------------------------------
// Precedence and the plainest form

#[test]
fn not_binds_before_and_before_or() {
    assert_picks(&[
        ("face=0 or face=1 and none", &[0]),
        ("none and face=1 or face=0", &[0]),
        ("(face=0 or face=1) and none", &[]),
        ("not face=0 and face=0..2", &[1, 2]),
        ("not (face=0 and face=0..2)", &[1, 2, 3, 4, 5]),
        ("not face=0..4 or face=1", &[1, 5]),
        ("not (face=0..4 or face=1)", &[5]),
        ("not not face=1", &[1]),
        ("!!face=1&!(face=2)", &[1]),
        ("face=0|face=1&none", &[0]),
        ("(((face=3)))", &[3]),
        ("not(all)", &[]),
        ("face=0or(face=1)", &[0, 1]),
    ]);
}

#[test]
fn the_plainest_form() {
    for (text, expected) in [
        ("  all ", "all"),
        ("((all))", "all"),
        ("all&none|boundary", "all and none or boundary"),
        ("all&(none|boundary)", "all and (none or boundary)"),
        ("(all|none)|boundary", "all or none or boundary"),
        ("(all & none) & (x>1 & y<2)", "all and none and x>1 and y<2"),
        ("!(! all)", "not not all"),
        ("!(all|none)", "not (all or none)"),
        ("(!all)|none", "not all or none"),
        ("group = \"lid\" , 'b'", "group=lid,b"),
        ("group='blue steel'", "group=\"blue steel\""),
        (r"group='it\'s'", "group=\"it's\""),
        (r#"group='say "a"'"#, r#"group="say \"a\"""#),
        (r"group='\*\?\\'", r#"group="\*\?\\""#),
        ("group='a:b*'", "group=\"a:b*\""),
        ("material=\"\"", "material=\"\""),
        ("face= 0 .. 09 , 7..7, 3..", "face=0..9,7,3.."),
        ("box=+1,2.50,-.5..1e0,1E+3,1e-7", "box=1,2.5,-0.5..1,1000,1e-7"),
        (
            "sphere=1e300,-1e15,123456789012345,0.00001",
            "sphere=1e300,-1e15,123456789012345,0.00001",
        ),
        ("plane= 0,0,1 , 0.1", "plane=0,0,1,0.1"),
        ("normal=0,0,1,30", "normal=0,0,1,30"),
        ("x >= 1 and y <= 2 and z < 3", "x>=1 and y<=2 and z<3"),
    ] {
        assert_eq!(canonical(text), expected, "{text}");
        assert_eq!(canonical(expected), expected);
        assert_eq!(text.parse::<Selection>(), expected.parse::<Selection>(), "{text}");
    }
    assert_ne!("face=1".parse::<Selection>(), "face=2".parse::<Selection>());
    assert_ne!("all and none".parse::<Selection>(), "all or none".parse::<Selection>());
}

/// As a shell argument, a selection and a number part at the last colon.
#[test]
fn a_number_can_follow_behind_a_colon() {
    for (argument, selection) in [
        ("group=lid:0.85", "group=lid"),
        ("group=\"a:b\" & z>0.5:1", "group=\"a:b\" & z>0.5"),
        ("(all):-2e3", "(all)"),
    ] {
        let (text, number) = argument.rsplit_once(':').unwrap();
        assert_eq!(text, selection);
        assert!(text.parse::<Selection>().is_ok() && number.parse::<f64>().is_ok(), "{argument}");
        assert!(argument.parse::<Selection>().is_err(), "{argument}");
    }
}

// ---------------------------------------------------------------------------------------------
// Mistakes

#[test]
fn mistakes_are_named_with_their_place() {
    const TEST: &str = "a test: all, none, boundary, group=, material=, face=, part=, corners=, \
        x<, y<, z<, plane=, box=, sphere= or normal=";
    for (text, message) in [
        ("", &*format!("column 1: the selection ends here; expected {TEST}")),
        ("  ", &format!("column 3: the selection ends here; expected {TEST}")),
        ("al", &format!("column 1: there is no test `al`; expected {TEST}")),
        ("all or", &format!("column 7: the selection ends here; expected {TEST}")),
        ("all or )", &format!("column 8: `)` does not fit here; expected {TEST}")),
        ("not", &format!("column 4: the selection ends here; expected {TEST}")),
        ("é & all", &format!("column 1: there is no test `é`; expected {TEST}")),
        ("3", &format!("column 1: `3` does not fit here; expected {TEST}")),
        ("all none", "column 5: `none` does not fit here; expected and, or, or the end"),
        ("all && none", &format!("column 6: `&` does not fit here; expected {TEST}")),
        ("all)", "column 4: `)` does not fit here; expected and, or, or the end"),
        ("group=lid:1", "column 10: `:` does not fit here; expected and, or, or the end"),
        (
            "all & (all | none",
            "column 18: the selection ends here; expected and, or, or `)` for the parenthesis at \
                column 7",
        ),
        ("group", "column 6: the selection ends here; expected `=`, as in group=lid"),
        ("group lid", "column 7: `lid` does not fit here; expected `=`, as in group=lid"),
        ("group=", "column 7: the selection ends here; expected a name, as in group=lid"),
        ("group=(", "column 7: `(` does not fit here; expected a name, as in group=lid"),
        ("group=a,", "column 9: the selection ends here; expected a name, as in group=lid"),
        ("group='é", "column 9: the quote at column 7 has no end; expected `'`"),
        (
            r"group='é\n'",
            "column 9: a lone `\\`; expected *, ?, \\, \" or ' behind it, or \\\\ for itself",
        ),
        (
            r"group='\",
            "column 8: a lone `\\`; expected *, ?, \\, \" or ' behind it, or \\\\ for itself",
        ),
        (
            "group='\u{1b}[1m'",
            "column 8: a control character `\\u{1b}` in a name; expected ? in its place",
        ),
        ("face=", "column 6: the selection ends here; expected a whole number, as in face=0..9,17"),
        ("face=-1", "column 6: `-` does not fit here; expected a whole number, as in face=0..9,17"),
        ("face=1.5", "column 7: `.` does not fit here; expected and, or, or the end"),
        ("face=7..3", "column 9: the range ends below its start, 7; expected a larger number"),
        (
            "face=4294967296",
            "column 6: the number is too large; expected a number below 4294967296",
        ),
        ("x", "column 2: the selection ends here; expected <, <=, > or >=, as in x>0.5"),
        ("x=1", "column 2: `=` does not fit here; expected <, <=, > or >=, as in x>0.5"),
        ("y>", "column 3: the selection ends here; expected a number, as in y>0.5"),
        ("y>nan", "column 3: `nan` does not fit here; expected a number, as in y>0.5"),
        ("z<-inf", "column 3: `-` does not fit here; expected a number, as in z>0.5"),
        ("z<1e999", "column 3: the number is too large; expected a number below 1.8e308"),
        ("z<.", "column 3: `.` does not fit here; expected a number, as in z>0.5"),
        ("z<1e", "column 4: `e` does not fit here; expected and, or, or the end"),
        ("box=1,2", "column 8: the selection ends here; expected `,`, as in box=X,Y,Z..X,Y,Z"),
        ("box=1,2,3,4", "column 10: `,` does not fit here; expected `..`, as in box=X,Y,Z..X,Y,Z"),
        (
            "sphere=0,0,0",
            "column 13: the selection ends here; expected `,`, as in sphere=X,Y,Z,RADIUS",
        ),
        ("sphere=0,0,0,-1", "column 14: the radius is negative; expected a radius of 0 or more"),
        (
            "normal=0,-0,1e-999,30",
            "column 8: the direction is zero; expected a number that is not zero",
        ),
        ("plane=0,0,0,1", "column 7: the direction is zero; expected a number that is not zero"),
        (
            "normal=0,0,1,181",
            "column 14: the angle is out of range; expected an angle from 0 to 180 degrees",
        ),
        (
            "normal=0,0,1,-1",
            "column 14: the angle is out of range; expected an angle from 0 to 180 degrees",
        ),
        // These need the mesh.
        ("all or face=3..6", "column 13: there is no face 6; expected a face from 0 to 5"),
        ("face=1,9..", "column 8: there is no face 9; expected a face from 0 to 5"),
        ("part=1", "column 6: there is no part 1; expected part 0, the only one"),
        (
            "none & group=lid,Lid*",
            "column 18: there is no group Lid*; expected \"\", lid, \"blue steel\", rim.001, \
                \"a\\*b:c\\\"d\\\\\"",
        ),
        ("material=lid", "column 10: there is no material lid; expected oak, tin"),
    ] {
        assert_eq!(error(text).to_string(), *message, "{text}");
    }
}

#[test]
fn the_place_is_in_bytes_and_in_characters() {
    let text = "group='äöü' & nn";
    let error = error(text);
    assert_eq!((error.at, error.column), (17, 15));
    assert_eq!(&text[error.at..], "nn");
}

#[test]
fn known_names_are_few_short_and_can_be_typed() {
    let mesh = crate::common::triangle();
    let names = ["a\tb", &"é".repeat(50), "c", "d", "e", "f", "g", "h"];
    let fails = |names: &[&str], of_face: &[u32]| {
        let groups = Some(Labels::new(names, of_face));
        let context = Context { groups, ..Context::new(&mesh) };
        "group=zzz".parse::<Selection>().unwrap().faces(&context).unwrap_err()
    };
    let expected = format!("a?b, {}*, c, d, e, f or one of 2 others", "é".repeat(40));
    assert_eq!(fails(&names, &[0]).expected, expected);
    assert_eq!(fails(&names[..7], &[0]).expected, expected.replace("one of 2 others", "one other"));
    for none in [
        fails(&[], &[7]),
        "group=a".parse::<Selection>().unwrap().faces(&Context::new(&mesh)).unwrap_err(),
    ] {
        assert_eq!(none.message, "the mesh has no group names");
    }
    assert_eq!(fails(&names, &[]).message, "the mesh has group names for 0 faces");
    // A label without a name is no name.
    let groups = Some(Labels::new(&names, &[8]));
    assert_eq!(picked("group=*", &Context { groups, ..Context::new(&mesh) }), [0; 0]);
}

#[test]
fn depth_is_bounded_and_length_is_not() {
    for open in ["(", "not ", "!", "!(", "not("] {
        for count in [65, 1_000_000] {
            let error = open.repeat(count).parse::<Selection>().unwrap_err();
            assert_eq!(error.message, "this is nested too deeply", "{open}");
            assert!(error.at <= 65 * open.len());
        }
    }
    let deep = |n: usize| format!("{}all{}", "(".repeat(n), ")".repeat(n));
    assert_eq!(canonical(&deep(64)), "all");
    assert!(deep(65).parse::<Selection>().is_err());
    // As deep as it goes, with a list at each level.
    let text = format!("{}z>0{}", "all & (none | ".repeat(64), ")".repeat(64));
    assert_eq!(canonical(&text).parse::<Selection>(), text.parse::<Selection>());
    labelled(|context| assert_eq!(picked(&text, context), [1, 2, 3, 4, 5]));

    for term in ["face=1", "(face=1)", "not not face=1", "!(!face=1)"] {
        let long = vec![term; 20_000].join(" or ");
        assert_eq!(labelled(|context| picked(&long, context)), [1], "{term}");
    }
    let long = format!("group={}", vec!["lid"; 20_000].join(","));
    assert_eq!(labelled(|context| picked(&long, context)), [1, 5]);
}

// ---------------------------------------------------------------------------------------------
// Random selections, against a second reading of the rules

/// What a random selection says, with its faces on the labelled cube.
#[derive(Clone, Debug)]
enum Said {
    Test(&'static str, [bool; 6]),
    Not(Box<Said>),
    And(Box<Said>, Box<Said>),
    Or(Box<Said>, Box<Said>),
}

impl Said {
    fn faces(&self) -> [bool; 6] {
        let join = |a: [bool; 6], b: [bool; 6], f: fn(bool, bool) -> bool| {
            std::array::from_fn(|i| f(a[i], b[i]))
        };
        match self {
            Self::Test(_, faces) => *faces,
            Self::Not(a) => a.faces().map(|face| !face),
            Self::And(a, b) => join(a.faces(), b.faces(), |a, b| a && b),
            Self::Or(a, b) => join(a.faces(), b.faces(), |a, b| a || b),
        }
    }

    fn strength(&self) -> u32 {
        match self {
            Self::Test(..) => 3,
            Self::Not(_) => 2,
            Self::And(..) => 1,
            Self::Or(..) => 0,
        }
    }

    /// Writes it with parentheses where they are needed, and elsewhere as the bits of `style` say,
    /// which choose among signs and words too.
    fn write(&self, to: &mut String, least: u32, style: &mut u64) {
        let mut choose = |n: u64| {
            *style = style.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888);
            (*style >> 33) % n
        };
        let closed = self.strength() < least || choose(6) == 0;
        let space = ["", " ", "\t\n "][choose(3) as usize];
        let sign = choose(2) == 0;
        let _ = write!(to, "{space}{}", if closed { "(" } else { "" });
        match self {
            Self::Test(text, _) => to.push_str(text),
            Self::Not(a) => {
                to.push_str(if sign { "!" } else { "not " });
                a.write(to, 2, style);
            }
            Self::And(a, b) => {
                a.write(to, 1, style);
                to.push_str(if sign { "&" } else { " and " });
                b.write(to, 1, style);
            }
            Self::Or(a, b) => {
                a.write(to, 0, style);
                to.push_str(if sign { "|" } else { " or " });
                b.write(to, 0, style);
            }
        }
        let _ = write!(to, "{}{space}", if closed { ")" } else { "" });
    }

    fn text(&self, mut style: u64) -> String {
        let mut text = String::new();
        self.write(&mut text, 0, &mut style);
        text
    }
}

fn said() -> impl Strategy<Value = Said> {
    const T: bool = true;
    const F: bool = false;
    let test = prop::sample::select(vec![
        ("all", [T; 6]),
        ("none", [F; 6]),
        ("boundary", [F; 6]),
        ("group=lid", [F, T, F, F, F, T]),
        ("group=\"blue steel\",rim.001", [F, F, T, T, F, F]),
        ("material='tin'", [F, F, F, T, T, T]),
        ("face=0..2,4", [T, T, T, F, T, F]),
        ("corners=4..", [T; 6]),
        ("part=0", [T; 6]),
        ("z>0.5", [F, T, F, F, F, F]),
        ("x<=5e-1", [T, T, T, T, T, F]),
        ("box=0,0,0..1,1,0.5", [T, F, T, T, T, T]),
        ("sphere=1,1,1,0.8", [F, T, F, T, F, T]),
        ("normal=0,1,1,46", [F, T, F, T, F, F]),
        ("plane=1,-1,0,-0.1", [T, T, T, F, F, T]),
    ])
    .prop_map(|(text, faces)| Said::Test(text, faces));
    test.prop_recursive(6, 40, 2, |inner| {
        let pair = || (inner.clone(), inner.clone());
        prop_oneof![
            inner.clone().prop_map(|a| Said::Not(a.into())),
            pair().prop_map(|(a, b)| Said::And(a.into(), b.into())),
            pair().prop_map(|(a, b)| Said::Or(a.into(), b.into())),
        ]
    })
}

/// Text that is nearly in the language.
fn nearly() -> impl Strategy<Value = String> {
    let piece = prop::sample::select(vec![
        "all",
        "none",
        "group",
        "material",
        "face",
        "part",
        "corners",
        "box",
        "sphere",
        "plane",
        "normal",
        "x",
        "z",
        "=",
        ">",
        "<=",
        ",",
        "..",
        ".",
        "(",
        ")",
        "and",
        "or",
        "not",
        "&",
        "|",
        "!",
        " ",
        "\"",
        "'",
        "\\",
        "*",
        "?",
        "0",
        "1",
        "-3.5",
        "1e3",
        "99999999999",
        "1e999",
        "é",
        "日",
        "\u{2028}",
        ":",
        "lid",
        "-",
        "+",
        "e",
    ]);
    prop::collection::vec(piece, 0..25).prop_map(|pieces| pieces.concat())
}

fn survives(text: &str) {
    let outcome = text.parse::<Selection>().and_then(|selection| {
        let again = selection.to_string().parse::<Selection>();
        assert_eq!(again.as_ref(), Ok(&selection), "{text:?}");
        assert_eq!(again.map(|s| s.to_string()), Ok(selection.to_string()), "{text:?}");
        labelled(|context| selection.faces(context))
    });
    if let Err(error) = outcome {
        assert!(text.is_char_boundary(error.at), "{text:?}: {error}");
        assert_eq!(error.column, text[..error.at].chars().count() + 1, "{text:?}: {error}");
        assert!(!error.message.is_empty() && !error.expected.is_empty(), "{text:?}: {error}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_said_is_selected(said in said(), style: u64) {
        let text = said.text(style);
        let selection: Selection = text.parse().unwrap();
        let faces = labelled(|context| selection.faces(context)).unwrap();
        prop_assert_eq!(&faces, &said.faces(), "{}", text);
        let plain = selection.to_string();
        prop_assert_eq!(&plain.parse::<Selection>().unwrap(), &selection, "{} as {}", text, plain);
        // Style is no part of it.
        prop_assert_eq!(&said.text(!style).parse::<Selection>().unwrap(), &selection);
    }

    #[test]
    fn de_morgan(a in said(), b in said(), style: u64) {
        let (a, b) = (a.text(style), b.text(!style));
        labelled(|context| {
            let neither = picked(&format!("not (({a}) or ({b}))"), context);
            assert_eq!(neither, picked(&format!("not ({a}) and not ({b})"), context));
            let not_both = picked(&format!("!(({a}) & ({b}))"), context);
            assert_eq!(not_both, picked(&format!("!({a}) | !({b})"), context));
        });
    }

    #[test]
    fn any_text_is_survived(text in any::<String>()) {
        survives(&text);
    }

    #[test]
    fn any_nearly_right_text_is_survived(text in nearly()) {
        survives(&text);
    }

    #[test]
    fn numbers_come_back_bit_by_bit(n in prop::array::uniform7(any::<f64>())) {
        prop_assume!(n.iter().all(|n| n.is_finite()) && n[0] != 0.0);
        let [x, y, z, u, v, w, d] = n;
        let turn = d.abs() % 180.0;
        let text = format!(
            "box={x:e},{y:e},{z:e}..{u:e},{v:e},{w:e} or plane={x},{y},{z},{d} or \
             sphere={x},{y},{z},{} or normal={x},{y},{z},{turn} or y<={d}",
            d.abs(),
        );
        let plain = canonical(&text);
        for (a, b) in plain.split(['=', ',', ' ']).zip(text.split(['=', ',', ' '])) {
            // A box joins two numbers by two points.
            for (a, b) in a.split("..").zip(b.split("..")) {
                if let (Ok(a), Ok(b)) = (a.parse::<f64>(), b.parse::<f64>()) {
                    prop_assert_eq!(a.to_bits(), b.to_bits(), "{}", plain);
                } else {
                    prop_assert_eq!(a, b);
                }
            }
        }
    }

    /// Against matching by plain recursion.
    #[test]
    fn patterns_match_as_by_the_definition(pattern in "[ab*?]{0,8}", name in "[ab]{0,8}") {
        fn matches(pattern: &[u8], name: &[u8]) -> bool {
            match (pattern, name) {
                ([], []) => true,
                ([b'*', rest @ ..], _) => (0..=name.len()).any(|n| matches(rest, &name[n..])),
                ([b'?', rest @ ..], [_, tail @ ..]) => matches(rest, tail),
                ([p, rest @ ..], [n, tail @ ..]) => p == n && matches(rest, tail),
                _ => false,
            }
        }
        let mesh = crate::common::triangle();
        let names = [name.as_str()];
        let context = Context { groups: Some(Labels::new(&names, &[0])), ..Context::new(&mesh) };
        let found = format!("group=\"{pattern}\"").parse::<Selection>().unwrap().faces(&context);
        prop_assert_eq!(found.is_ok(), matches(pattern.as_bytes(), name.as_bytes()));
    }
}

// ---------------------------------------------------------------------------------------------
// Growing and shrinking

/// One ring is what shares a vertex, by looking at all pairs of faces.
#[test]
fn growing_adds_what_shares_a_vertex() {
    for (name, mesh) in crate::common::assorted() {
        let topology = mesh.topology();
        let count = topology.face_count();
        let shares = |f: usize, g: usize| {
            let corners = |f: usize| topology.face_vertices(FaceId(f as u32));
            corners(f).iter().any(|v| corners(g).contains(v))
        };
        let mut selected = vec![false; count];
        for f in [0, count / 2, count - 1] {
            selected[f] = true;
            let once: Vec<bool> =
                (0..count).map(|g| (0..count).any(|f| selected[f] && shares(f, g))).collect();
            let twice: Vec<bool> =
                (0..count).map(|g| (0..count).any(|f| once[f] && shares(f, g))).collect();
            assert_eq!(grow(topology, &selected, 0), selected, "{name}");
            assert_eq!(grow(topology, &selected, 1), once, "{name}");
            assert_eq!(grow(topology, &selected, 2), twice, "{name}");
            let not = |faces: &[bool]| faces.iter().map(|f| !f).collect::<Vec<_>>();
            assert_eq!(not(&shrink(topology, &not(&selected), 2)), twice, "{name}");
        }
    }
}

#[test]
fn growing_stops_at_the_part_and_shrinking_spares_the_boundary() {
    let several = crate::common::several();
    let topology = several.topology();
    let mut selected = vec![false; 25];
    selected[3] = true;
    assert_eq!(numbers(&grow(topology, &selected, u32::MAX)), (0..20).collect::<Vec<_>>());
    assert_eq!(shrink(topology, &[true; 25], u32::MAX), [true; 25]);
    assert_eq!(shrink(topology, &selected, 1), [false; 25]);
    assert_eq!(grow(topology, &[false; 25], u32::MAX), [false; 25]);
}

// ---------------------------------------------------------------------------------------------
// Falloff

/// Round a cube the centres are one apart along the surface, and √½ through the air.
#[test]
fn distance_is_along_the_surface() {
    let cube = shapes::cube();
    let lid = [false, true, false, false, false, false];
    let weight = |t: f64| 1.0 - t * t * (3.0 - 2.0 * t);
    let side = weight(1.0 / 4.0);
    let expected = [weight(2.0 / 4.0), 1.0, side, side, side, side];
    for (actual, expected) in falloff(&cube, &lid, 4.0).unwrap().iter().zip(expected) {
        assert!((actual - expected).abs() < 1e-15, "{actual} {expected}");
    }
    assert_eq!(falloff(&cube, &lid, 1.0).unwrap(), [0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(falloff(&cube, &lid, 0.0).unwrap(), [0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
}

/// Folding a strip along its edges keeps all distances.
#[test]
fn folding_changes_no_distance() {
    let flat = shapes::sheet(2, 12, |_, _| 0.0);
    let folded = flat.positions().iter().map(|p| {
        let (step, t) = ((p.x * 11.0).round() as usize, 1.0 / 11.0);
        let right = step.div_ceil(2) as f64;
        Vec3::new(right * t, p.y, (step as f64 - right) * t)
    });
    let folded = flat.with_positions(folded.collect());
    let mut selected = [false; 22];
    selected[0] = true;
    let (a, b) = (falloff(&flat, &selected, 0.9), falloff(&folded, &selected, 0.9));
    for (a, b) in a.unwrap().iter().zip(b.unwrap()) {
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }
}

#[test]
fn what_cannot_be_reached_has_no_weight() {
    let several = crate::common::several();
    let mut selected = [false; 25];
    selected[20] = true;
    let weights = falloff(&several, &selected, f64::MAX).unwrap();
    assert_eq!(weights[..20], [0.0; 20]);
    assert!(weights[20..].iter().all(|&w| w > 0.999));
    assert_eq!(falloff(&several, &[false; 25], 1.0).unwrap(), [0.0; 25]);
    assert_eq!(falloff(&several, &[true; 25], 0.0).unwrap(), [1.0; 25]);
    for value in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(falloff(&several, &selected, value), Err(Error::BadOption { .. })));
    }
}

#[test]
fn huge_coordinates_and_faces_without_extent_are_survived() {
    let cube = shapes::cube();
    let lid = [false, true, false, false, false, false];
    let huge = cube.positions().iter().map(|&p| 1.7e308 * (2.0 * p + Vec3::splat(-1.0)));
    let huge = cube.with_positions(huge.collect());
    assert_eq!(falloff(&huge, &lid, 1e300).unwrap()[0], 0.0);
    let point = cube.with_positions(vec![Vec3::ZERO; 8]);
    assert_eq!(falloff(&point, &lid, 1.0).unwrap(), [1.0; 6]);
    assert_eq!(falloff(&point, &lid, 0.0).unwrap(), [1.0; 6]);
    let tiny = cube.positions().iter().map(|&p| 1e-310 * p).collect();
    let tiny = falloff(&cube.with_positions(tiny), &lid, 4e-310).unwrap();
    assert!((tiny[2] - 27.0 / 32.0).abs() < 1e-6, "{tiny:?}");
}

/// Along a strip the weights never rise, and they follow the distance they fall off over without
/// jumps.
#[test]
fn falloff_is_monotone_in_place_and_in_distance() {
    let points = (0..41).flat_map(|i| {
        let x = f64::from(i) / 40.0;
        [Vec3::new(x, 0.0, x * x), Vec3::new(x, 1.0 - 0.5 * x, x * x)]
    });
    let quads: Faces = (0..40).map(|i| [0, 2, 3, 1].map(|corner| 2 * i + corner)).collect();
    let strip = Mesh::new(points.collect(), &quads).unwrap();
    let mut selected = vec![false; 40];
    selected[..4].fill(true);
    let mut last = vec![0.0; 40];
    for step in 0..=2000 {
        let distance = f64::from(step) / 1000.0;
        let weights = falloff(&strip, &selected, distance).unwrap();
        assert_eq!(weights[..4], [1.0; 4]);
        assert!(weights.is_sorted_by(|a, b| a >= b), "{distance}: {weights:?}");
        if step > 40 {
            for (f, (&now, &before)) in weights.iter().zip(&last).enumerate() {
                let most = 1.5 * 0.001 / distance + 1e-12;
                assert!(now >= before && now - before <= most, "{f} at {distance}");
            }
        }
        last = weights;
    }
    assert!(last[39] > 0.0 && last[39] < last[20]);
}

/// Straight through the air is never longer than along the surface, so what is farther than
/// `distance` from every selected face has weight 0; and faces beside the selection have some.
#[test]
fn falloff_keeps_to_its_distance() {
    for seed in 1..60 {
        let mesh = crate::common::random_mesh(seed, 30, 5);
        let topology = mesh.topology();
        let count = topology.face_count();
        let selected: Vec<bool> = (0..count as u64).map(|f| (f * 7 + seed) % 11 == 0).collect();
        let centre = |f: usize| -> Vec3 {
            let corners = topology.face_vertices(FaceId(f as u32));
            corners.iter().map(|v| mesh.positions()[v.index()]).sum::<Vec3>() / 3.0
        };
        let distance = 0.1 * (seed % 9) as f64;
        let weights = falloff(&mesh, &selected, distance).unwrap();
        for f in 0..count {
            let w = weights[f];
            assert!((0.0..=1.0).contains(&w) && (w == 1.0) >= selected[f], "{seed}: {f} has {w}");
            let air = |g: usize| (centre(f) - centre(g)).length();
            let near = (0..count).filter(|&g| selected[g]).map(air).fold(f64::INFINITY, f64::min);
            assert!(w == 0.0 || near <= distance, "{seed}: {f} has {w}, but is {near} away");
        }
        // Not how the faces are numbered, only where they are.
        let back: Faces =
            (0..count).rev().map(|f| topology.to_faces().get(FaceId(f as u32)).to_vec()).collect();
        let back = Mesh::new(mesh.positions().to_vec(), &back).unwrap();
        let turned: Vec<bool> = selected.iter().rev().copied().collect();
        for (a, b) in falloff(&back, &turned, distance).unwrap().iter().rev().zip(&weights) {
            assert!((a - b).abs() < 1e-9, "{seed}: {a} {b}");
        }
    }
}

#[test]
fn blending_goes_from_the_base_to_the_value() {
    let mut base = [1.0, 1.0, 2.0, 0.1];
    blend(&mut base, &[0.0, 0.5, 0.25, 1.0], 0.3);
    assert_eq!(base, [1.0, 0.65, 1.575, 0.3]);
}

// ---------------------------------------------------------------------------------------------
// Speed

/// Everything on 100,000 faces at once, with time to spare in a debug build on a busy machine.
#[test]
fn a_hundred_thousand_faces_are_quick() {
    let mesh = shapes::torus(250, 200);
    let names: Vec<String> = (0..100).map(|i| format!("group {i}")).collect();
    let of_face: Vec<u32> = (0..100_000).map(|f| f / 1000).collect();
    let groups = Some(Labels::new(&names, &of_face));
    let context = Context { groups, ..Context::new(&mesh) };
    let start = Instant::now();
    let text = "(group=\"group 1*\" or z>0 and normal=0,0,1,30 | sphere=1,0,0,0.5) & \
        !box=0,0,0..1,1,1 & part=0 & not boundary & corners=3 & face=0..99999";
    let faces = text.parse::<Selection>().unwrap().faces(&context).unwrap();
    let selected = numbers(&faces).len();
    assert!((20_000..80_000).contains(&selected), "{selected}");
    let grown = shrink(mesh.topology(), &grow(mesh.topology(), &faces, 20), 10);
    let weights = falloff(&mesh, &grown, 0.5).unwrap();
    assert!(weights.iter().any(|&w| w > 0.0 && w < 1.0));
    assert!(start.elapsed() < Duration::from_secs(5), "{:?}", start.elapsed());
}
