//! Published masks, as exact fractions.

use fairform::scheme::loop_scheme::{
    BoundaryKind, boundary_edge_weights, boundary_limit_weight, boundary_scale,
    inward_tangent_centre_weight, inward_tangent_weight, limit_weight, ring_weight,
    tangent_weights,
};

use BoundaryKind::{Corner, Extraordinary as E, Regular as R};

#[test]
fn interior_weights() {
    for (n, ring, limit) in
        [(3, 9.0 / 16.0, 2.0 / 5.0), (4, 31.0 / 64.0, 24.0 / 55.0), (6, 3.0 / 8.0, 0.5)]
    {
        assert!((ring_weight(n) - ring).abs() < 1e-15, "valence {n}");
        assert!((limit_weight(n) - limit).abs() < 1e-15, "valence {n}");
    }
    assert!((limit_weight(5) - 0.471_421_726_9).abs() < 1e-10);
    assert!((limit_weight(1_000_000) - 8.0 / 13.0).abs() < 1e-6);
    assert!((limit_weight(2) - 8.0 / 21.0).abs() < 1e-15);
    assert!((3..1000).all(|n| limit_weight(n) < limit_weight(n + 1)), "increasing");
}

/// The six masks of the paper as numerators over 48 (regular centre) and 40 (extraordinary).
#[test]
fn the_six_boundary_masks() {
    let table = [
        (R, R, R, [8, 32, 8], 48),
        (R, R, E, [8, 33, 7], 48),
        (R, E, E, [7, 34, 7], 48),
        (E, R, R, [8, 24, 8], 40),
        (E, R, E, [8, 25, 7], 40),
        (E, E, E, [7, 26, 7], 40),
    ];
    for (centre, left, right, [l, c, r], of) in table {
        let weights = [left, right].map(|q| boundary_limit_weight(centre, q));
        let expected = [l, r].map(|w| f64::from(w) / f64::from(of));
        assert_eq!(weights, expected, "{centre:?} between {left:?} and {right:?}");
        assert!((1.0 - weights[0] - weights[1] - f64::from(c) / f64::from(of)).abs() < 1e-15);
    }
}

/// The limit of a boundary vertex is that of its local refinement, where the masks are the plain
/// ones: this derives all weights, those beside a sharp corner too.
#[test]
fn boundary_masks_compose_one_step_with_the_plain_masks() {
    for (centre, ends) in [(R, 1.0 / 6.0), (E, 1.0 / 5.0)] {
        for neighbour in [R, E, Corner] {
            let [_, far] = boundary_edge_weights(centre, neighbour);
            let expected = ends * far + (1.0 - 2.0 * ends) / 8.0;
            assert!((boundary_limit_weight(centre, neighbour) - expected).abs() < 1e-15);
        }
    }
}

#[test]
fn tangent_masks_sum_to_zero() {
    for n in 3..100 {
        for axis in 0..2 {
            let sum: f64 = (0..n).map(|i| tangent_weights(n, i)[axis]).sum();
            assert!(sum.abs() < 1e-13, "valence {n}");
        }
    }
    for k in 1..4 {
        let ring: f64 = (0..=k).map(|i| inward_tangent_weight(k, i)).sum();
        assert!((ring + inward_tangent_centre_weight(k)).abs() < 1e-15, "{k} faces");
    }
    // For four and more the centre takes no part: the inner weights balance the ends by themselves.
    for k in 4..50 {
        let sum: f64 = (0..=k).map(|i| inward_tangent_weight(k, i)).sum();
        assert!(sum.abs() < 1e-13, "{k} faces: {sum}");
    }
}

/// Row `i` of the boundary operator is its scale times a row of a symmetric matrix.
#[test]
fn the_boundary_operator_is_symmetric_up_to_scale() {
    let entry = |a, b| boundary_limit_weight(a, b) / boundary_scale(a);
    assert!((entry(R, E) - entry(E, R)).abs() < 1e-17);
    assert!((entry(R, E) - 1.0 / 240.0).abs() < 1e-17);
}
