//! What JavaScript sees: typed arrays in, fresh typed arrays out, small structures as JSON. Nothing is
//! decided here. `studio/src/kernel/worker.ts` is the one who calls.

use std::ops::ControlFlow;

use fairform::Vec3;
use fairform_io::Format;
use fairform_io::project::{self, Design, Fineness};
use js_sys::{Float32Array, Object, Reflect, Uint8Array, Uint32Array};
use serde::Serialize;
use serde::de::DeserializeOwned;
use wasm_bindgen::prelude::*;

use crate::{DragAnswer, Geometry, MeshSession, PatchGeometry, Problem, StreamSession, Values};

type Answer<T> = Result<T, JsValue>;

/// A problem is thrown as its JSON.
impl From<Problem> for JsValue {
    fn from(problem: Problem) -> Self {
        Self::from_str(&json(&problem))
    }
}

fn json(value: &impl Serialize) -> String {
    serde_json::to_string(value).unwrap_or_default()
}

fn read<T: DeserializeOwned>(text: &str, what: &str) -> Result<T, Problem> {
    serde_json::from_str(text).map_err(|e| Problem::at(what, e))
}

fn floats(values: &[[f32; 3]]) -> JsValue {
    Float32Array::from(bytemuck::cast_slice::<_, f32>(values)).into()
}

fn numbers<T: bytemuck::NoUninit>(values: &[T]) -> JsValue {
    Uint32Array::from(bytemuck::cast_slice::<_, u32>(values)).into()
}

fn object(fields: &[(&str, JsValue)]) -> Object {
    let object = Object::new();
    for (name, value) in fields {
        // Only frozen objects refuse.
        let _ = Reflect::set(&object, &JsValue::from_str(name), value);
    }
    object
}

fn geometry(geometry: &Geometry) -> Object {
    object(&[
        ("positions", floats(&geometry.positions)),
        ("normals", floats(&geometry.normals)),
        ("triangles", numbers(&geometry.triangles)),
        ("faceOfTriangle", numbers(&geometry.face_of_triangle)),
        ("edges", numbers(&geometry.edges)),
    ])
}

fn values(values: &Values) -> Object {
    object(&[
        ("values", Float32Array::from(&values.values[..]).into()),
        ("low", values.low.into()),
        ("high", values.high.into()),
        ("label", values.label.into()),
    ])
}

fn format(name: &str) -> Result<Format, Problem> {
    name.parse().map_err(Problem::new)
}

/// Panics become messages in the console instead of `unreachable`.
#[wasm_bindgen(start)]
pub fn start() {
    console_error_panic_hook::set_once();
}

/// The version of the kernel.
#[wasm_bindgen]
#[must_use]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").into()
}

/// [`MeshSession`] for JavaScript.
#[wasm_bindgen]
pub struct MeshKernel {
    session: MeshSession,
}

#[wasm_bindgen]
impl MeshKernel {
    /// Opens a mesh; `repairs` is a list of names as JSON.
    ///
    /// # Errors
    /// As [`MeshSession::open`].
    pub fn open(bytes: &[u8], name: &str, repairs: &str) -> Answer<MeshKernel> {
        let repairs: Vec<String> = read(repairs, "repairs")?;
        Ok(Self { session: MeshSession::open(bytes, name, &repairs)? })
    }

    /// See [`MeshSession::info`]; JSON.
    #[must_use]
    pub fn info(&self) -> String {
        json(&self.session.info())
    }

    /// See [`MeshSession::given`].
    #[must_use]
    pub fn given(&self) -> Object {
        let given = self.session.given();
        let object = geometry(&given.geometry);
        let fields = [
            ("boundary", Uint32Array::from(&given.boundary[..]).into()),
            ("ends", numbers(&given.geometry.edges)),
        ];
        Object::assign(&object, &self::object(&fields))
    }

    /// See [`MeshSession::fit`]; JSON in and out. `progress` is called with stage, iteration, largest and
    /// mean distance.
    ///
    /// # Errors
    /// As [`MeshSession::fit`].
    pub fn fit(&mut self, design: &str, progress: &js_sys::Function) -> Answer<String> {
        let design: Design = read(design, "design")?;
        let mut observer = |step: &crate::Progress| {
            let args = js_sys::Array::of4(
                &step.stage.into(),
                &step.iteration.into(),
                &step.max.into(),
                &step.mean.into(),
            );
            match progress.apply(&JsValue::NULL, &args) {
                Ok(_) => ControlFlow::Continue(()),
                Err(_) => ControlFlow::Break(()),
            }
        };
        Ok(json(&self.session.fit(&design, &mut observer)?))
    }

    /// See [`MeshSession::control`].
    ///
    /// # Errors
    /// As there.
    pub fn control(&self, iteration: Option<u32>) -> Answer<Object> {
        Ok(geometry(&self.session.control(iteration)?))
    }

    /// See [`MeshSession::surface`].
    ///
    /// # Errors
    /// As there.
    pub fn surface(&mut self, levels: u32, limit: bool, iteration: Option<u32>) -> Answer<Object> {
        let fineness = Fineness { levels, limit };
        Ok(geometry(&self.session.surface(fineness, iteration)?))
    }

    /// See [`MeshSession::values`].
    ///
    /// # Errors
    /// As there.
    pub fn values(&self, colouring: &str) -> Answer<Object> {
        Ok(values(&self.session.values(colouring.parse()?)?))
    }

    /// See [`MeshSession::query`]; the query is JSON.
    ///
    /// # Errors
    /// As there.
    pub fn query(&self, selected: &[u8], query: &str) -> Answer<Uint8Array> {
        let found = self.session.query(selected, &read(query, "query")?)?;
        Ok(Uint8Array::from(&found[..]))
    }

    /// See [`MeshSession::spread_tension`]; JSON in and out.
    ///
    /// # Errors
    /// As there.
    pub fn spread_tension(
        &self,
        design: &str,
        selected: &[u8],
        value: f64,
        distance: f64,
    ) -> Answer<String> {
        let design: Design = read(design, "design")?;
        Ok(json(&self.session.spread_tension(&design, selected, value, distance)?))
    }

    /// See [`MeshSession::grab`].
    ///
    /// # Errors
    /// As there.
    pub fn grab(&mut self, vertices: &[u32]) -> Answer<()> {
        Ok(self.session.grab(vertices)?)
    }

    /// See [`MeshSession::drag`].
    ///
    /// # Errors
    /// As there.
    pub fn drag(&mut self, x: f64, y: f64, z: f64) -> Answer<Object> {
        Ok(moved(&self.session.drag(Vec3::new(x, y, z))?))
    }

    /// See [`MeshSession::release`]; the moves are JSON.
    ///
    /// # Errors
    /// As there.
    pub fn release(&mut self) -> Answer<Object> {
        let released = self.session.release()?;
        Ok(object(&[
            ("moves", json(&released.moves).into()),
            ("max", released.max.into()),
            ("answer", moved(&released.answer).into()),
        ]))
    }

    /// See [`MeshSession::save`].
    ///
    /// # Errors
    /// As there.
    pub fn save(&self, what: &str, to: &str) -> Answer<Uint8Array> {
        Ok(Uint8Array::from(&self.session.save(what.parse()?, format(to)?)?[..]))
    }
}

fn moved(answer: &DragAnswer) -> Object {
    let vertices = answer.vertices.as_ref();
    object(&[
        ("vertices", vertices.map_or(JsValue::NULL, |v| Uint32Array::from(&v[..]).into())),
        ("positions", floats(&answer.positions)),
        ("normals", floats(&answer.normals)),
        ("controlVertices", Uint32Array::from(&answer.control_vertices[..]).into()),
        ("controlPositions", floats(&answer.control_positions)),
    ])
}

/// [`StreamSession`] for JavaScript.
#[wasm_bindgen]
pub struct StreamKernel {
    session: StreamSession,
}

fn patch(patch: &PatchGeometry) -> Object {
    let object = geometry(&patch.geometry);
    let fields = [
        ("rowCount", (patch.row_count as f64).into()),
        ("columnCount", (patch.column_count as f64).into()),
        ("feet", floats(&patch.feet)),
        ("tangents", floats(&patch.tangents)),
        ("fineTangents", floats(&patch.fine_tangents)),
        ("others", Uint32Array::from(&patch.others[..]).into()),
    ];
    Object::assign(&object, &self::object(&fields))
}

fn vector(v: &[f64]) -> Result<Vec3, Problem> {
    match *v {
        [x, y, z] => Ok(Vec3::new(x, y, z)),
        _ => Err(Problem::new("a direction has three numbers")),
    }
}

fn numbers_of(v: Vec3) -> Vec<f64> {
    <[f64; 3]>::from(v).to_vec()
}

#[wasm_bindgen]
impl StreamKernel {
    /// Opens a model.
    ///
    /// # Errors
    /// As [`StreamSession::open`].
    pub fn open(bytes: &[u8], name: &str) -> Answer<StreamKernel> {
        Ok(Self { session: StreamSession::open(bytes, name)? })
    }

    /// See [`StreamSession::set`].
    ///
    /// # Errors
    /// As there.
    pub fn set(&mut self, model: &str) -> Answer<()> {
        Ok(self.session.set(model.as_bytes())?)
    }

    /// See [`StreamSession::text`].
    ///
    /// # Errors
    /// As there.
    pub fn text(&self) -> Answer<Uint8Array> {
        Ok(Uint8Array::from(&self.session.text()?[..]))
    }

    /// See [`StreamSession::info`]; JSON.
    #[must_use]
    pub fn info(&self) -> String {
        json(&self.session.info())
    }

    /// See [`StreamSession::patch`].
    ///
    /// # Errors
    /// As there.
    pub fn patch(&self, index: usize) -> Answer<Object> {
        Ok(patch(&self.session.patch(index)?))
    }

    /// See [`StreamSession::set_tangent`].
    ///
    /// # Errors
    /// As there.
    pub fn set_tangent(
        &mut self,
        index: usize,
        row: usize,
        column: usize,
        tangent: &[f64],
    ) -> Answer<Object> {
        Ok(patch(&self.session.set_tangent(index, row, column, vector(tangent)?)?))
    }

    /// See [`StreamSession::arcs`].
    ///
    /// # Errors
    /// As there.
    pub fn arcs(&self, index: usize, rows: bool, steps: usize) -> Answer<JsValue> {
        Ok(floats(&self.session.arcs(index, rows, steps)?))
    }

    /// See [`StreamSession::values`].
    ///
    /// # Errors
    /// As there.
    pub fn values(&self, index: usize, colouring: &str) -> Answer<Object> {
        Ok(values(&self.session.values(index, colouring.parse()?)?))
    }

    /// See [`StreamSession::combs`].
    ///
    /// # Errors
    /// As there.
    pub fn combs(&self, index: usize, scale: f64) -> Answer<JsValue> {
        Ok(floats(self.session.combs(index, scale)?.as_flattened()))
    }

    /// See [`StreamSession::save`].
    ///
    /// # Errors
    /// As there.
    pub fn save(&self, to: &str) -> Answer<Uint8Array> {
        Ok(Uint8Array::from(&self.session.save(format(to)?)?[..]))
    }
}

/// See [`edit`](crate::edit); JSON in and out.
///
/// # Errors
/// As there.
#[wasm_bindgen(js_name = editModel)]
pub fn edit_model(model: &str, change: &str) -> Answer<String> {
    let changed = crate::edit(model.as_bytes(), &read(change, "change")?)?;
    Ok(String::from_utf8_lossy(&changed).into_owned())
}

/// See [`set_component`](crate::set_component).
///
/// # Errors
/// As there.
#[wasm_bindgen(js_name = setComponent)]
pub fn set_component(tangent: &[f64], axis: usize, value: f64) -> Answer<Vec<f64>> {
    Ok(numbers_of(crate::set_component(vector(tangent)?, axis, value)?))
}

/// See [`rotate`](crate::rotate).
///
/// # Errors
/// As there.
#[wasm_bindgen]
pub fn rotate(tangent: &[f64], axis: &[f64], degrees: f64) -> Answer<Vec<f64>> {
    Ok(numbers_of(crate::rotate(vector(tangent)?, vector(axis)?, degrees)?))
}

/// The project in the bytes of a file, checked, as JSON with all defaults filled in.
///
/// # Errors
/// As [`project::parse`].
#[wasm_bindgen(js_name = readProject)]
pub fn read_project(bytes: &[u8]) -> Answer<String> {
    let project = project::parse(bytes).map_err(Problem::from)?;
    Ok(json(&project))
}

/// A project, checked, as the bytes of a file.
///
/// # Errors
/// As [`project::parse`].
#[wasm_bindgen(js_name = writeProject)]
pub fn write_project(text: &str) -> Answer<Uint8Array> {
    let project = project::parse(text.as_bytes()).map_err(Problem::from)?;
    Ok(Uint8Array::from(&project::encode(&project)[..]))
}
