//! JSON Schema, as far as our schema uses it: any other keyword is a panic, not a pass.

use serde_json::{Map, Value};

/// A schema with its definitions.
pub(crate) struct Schema(pub(crate) Value);

impl Schema {
    pub(crate) fn accepts(&self, value: &Value) -> bool {
        self.holds(&self.0, value)
    }

    fn holds(&self, schema: &Value, value: &Value) -> bool {
        let rules = schema.as_object().expect("a schema is an object");
        rules.iter().all(|(keyword, rule)| self.rule(keyword, rule, rules, value))
    }

    fn rule(&self, keyword: &str, rule: &Value, all: &Map<String, Value>, value: &Value) -> bool {
        let count = || all_of(rule).filter(|rule| self.holds(rule, value)).count();
        let number = |ok: fn(f64, f64) -> bool| {
            value.as_f64().is_none_or(|x| ok(x, rule.as_f64().expect("a number")))
        };
        match keyword {
            "$schema" | "$id" | "$defs" | "title" | "description" | "default" => true,
            "$ref" => {
                let place =
                    rule.as_str().unwrap().strip_prefix('#').expect("a place in this schema");
                self.holds(self.0.pointer(place).expect("a definition"), value)
            }
            "type" => match rule.as_str().unwrap() {
                "object" => value.is_object(),
                "array" => value.is_array(),
                "string" => value.is_string(),
                "boolean" => value.is_boolean(),
                "number" => value.is_number(),
                "integer" => value.as_f64().is_some_and(|x| x.trunc() == x),
                other => panic!("no type {other}"),
            },
            "const" => equal(rule, value),
            "enum" => all_of(rule).any(|one| equal(one, value)),
            "anyOf" => count() > 0,
            "oneOf" => count() == 1,
            "not" => !self.holds(rule, value),
            "minimum" => number(|x, limit| x >= limit),
            "maximum" => number(|x, limit| x <= limit),
            "exclusiveMinimum" => number(|x, limit| x > limit),
            "minItems" => value.as_array().is_none_or(|l| l.len() as u64 >= rule.as_u64().unwrap()),
            "maxItems" => value.as_array().is_none_or(|l| l.len() as u64 <= rule.as_u64().unwrap()),
            "items" => value.as_array().is_none_or(|l| l.iter().all(|one| self.holds(rule, one))),
            "required" => value.as_object().is_none_or(|object| {
                all_of(rule).all(|name| object.contains_key(name.as_str().unwrap()))
            }),
            "properties" => value.as_object().is_none_or(|object| {
                let known = rule.as_object().unwrap();
                known
                    .iter()
                    .all(|(name, rule)| object.get(name).is_none_or(|v| self.holds(rule, v)))
            }),
            "additionalProperties" => value.as_object().is_none_or(|object| {
                assert_eq!(rule, false);
                object.keys().all(|name| all["properties"].get(name).is_some())
            }),
            other => panic!("no keyword {other}"),
        }
    }
}

fn all_of(rule: &Value) -> impl Iterator<Item = &Value> {
    rule.as_array().expect("a list").iter()
}

/// 1 and 1.0 are the same.
fn equal(a: &Value, b: &Value) -> bool {
    a == b || (a.is_number() && a.as_f64() == b.as_f64())
}
