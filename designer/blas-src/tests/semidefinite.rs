//! clarabel on semidefinite programs of known optimum, each with an infeasible twin.
//!
//! All are linear matrix inequalities: minimise c'x such that F_0 + x_1 F_1 + ... is positive
//! semidefinite. They are of order four and more, below which clarabel has formulas of its own.

#![allow(clippy::expect_used)] // in the functions that the tests share

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolution, DefaultSolver, IPSolver, SolverStatus, SupportedConeT,
};
use nalgebra::{DMatrix, DVector};

/// The upper triangle by columns, the off-diagonal elements times sqrt(2): clarabel's order.
fn svec(f: &DMatrix<f64>) -> Vec<f64> {
    let upper = (0..f.ncols()).flat_map(|j| (0..=j).map(move |i| (i, j)));
    upper.map(|(i, j)| if i == j { f[(i, j)] } else { f[(i, j)] * 2f64.sqrt() }).collect()
}

/// Minimises c'x such that for each inequality, given by its F_0 and F_1 ..., the sum is positive
/// semidefinite.
fn minimise(c: &[f64], inequalities: &[(DMatrix<f64>, Vec<DMatrix<f64>>)]) -> DefaultSolution<f64> {
    let rows: Vec<f64> = inequalities.iter().flat_map(|(f0, _)| svec(f0)).collect();
    let columns = (0..c.len()).map(|i| {
        let column = inequalities.iter().flat_map(|(_, f)| svec(&f[i]));
        DVector::from_iterator(rows.len(), column.map(|value| -value))
    });
    let a = DMatrix::from_columns(&columns.collect::<Vec<_>>());
    let by_rows: Vec<Vec<f64>> = a.row_iter().map(|row| row.iter().copied().collect()).collect();
    let cones: Vec<_> =
        inequalities.iter().map(|(f0, _)| SupportedConeT::PSDTriangleConeT(f0.nrows())).collect();
    let settings = DefaultSettingsBuilder::default().verbose(false).build().expect("settings");
    let (p, a) = (CscMatrix::zeros((c.len(), c.len())), CscMatrix::from(&by_rows));
    let mut solver = DefaultSolver::new(&p, c, &a, &rows, &cones, settings).expect("problem");
    solver.solve();
    solver.solution
}

fn assert_optimum(solution: &DefaultSolution<f64>, optimum: f64) {
    assert_eq!(solution.status, SolverStatus::Solved);
    let error = (solution.obj_val - optimum).abs() / optimum.abs();
    assert!(error < 1e-7, "{} is not {optimum}", solution.obj_val);
}

/// The smallest t with t I - A positive semidefinite is the largest eigenvalue: of the path of n
/// nodes' Laplacian, 2 + 2 cos(pi / n).
#[test]
fn largest_eigenvalue() {
    let n = 12;
    let laplacian = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
        0 if i == 0 || i == n - 1 => 1.0,
        0 => 2.0,
        1 => -1.0,
        _ => 0.0,
    });
    let identity = DMatrix::identity(n, n);
    let above = (-&laplacian, vec![identity.clone()]);
    let solution = minimise(&[1.0], std::slice::from_ref(&above));
    assert_optimum(&solution, 2.0 + 2.0 * (std::f64::consts::PI / n as f64).cos());

    let below_three = (3.0 * &identity, vec![-identity]);
    let solution = minimise(&[1.0], &[above, below_three]);
    assert_eq!(solution.status, SolverStatus::PrimalInfeasible);
}

/// Lovasz's number of the cycle of five nodes is sqrt(5): the smallest t such that t I - J is
/// positive semidefinite for some choice of the elements that belong to edges.
#[test]
fn lovasz_number() {
    let n = 5;
    let edge = |k: usize| {
        DMatrix::from_fn(n, n, |i, j| f64::from([(i, j), (j, i)].contains(&(k, (k + 1) % n))))
    };
    let f0 = DMatrix::from_element(n, n, -1.0);
    let mut f = vec![DMatrix::identity(n, n)];
    f.extend((0..n).map(edge));
    let c = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    assert_optimum(&minimise(&c, &[(f0.clone(), f.clone())]), 5f64.sqrt());

    let mut at_most_two = vec![DMatrix::zeros(n, n); c.len()];
    at_most_two[0] = -DMatrix::identity(n, n);
    let cap = (DMatrix::identity(n, n) * 2.0, at_most_two);
    assert_eq!(minimise(&c, &[(f0, f), cap]).status, SolverStatus::PrimalInfeasible);
}

/// The P of least trace with -(A'P + P A) - Q positive semidefinite solves Lyapunov's equation.
/// With A = T^-1 (S - I) T for a skew S, and Q = 2 T'T, that is P = T'T. The unstable -A has none.
#[test]
fn lyapunov_inequality() {
    let n = 6;
    let t =
        DMatrix::from_fn(n, n, |i, j| if i == j { 2.0 } else { ((3 * i + 5 * j) as f64).sin() });
    let skew = DMatrix::from_fn(n, n, |i, j| ((i + j) as f64).cos() * (i as f64 - j as f64));
    let a = t.clone().try_inverse().expect("regular") * (skew - DMatrix::identity(n, n)) * &t;
    let p = t.transpose() * &t;

    let basis: Vec<DMatrix<f64>> = (0..n)
        .flat_map(|j| (0..=j).map(move |i| (i, j)))
        .map(|(i, j)| {
            let mut e = DMatrix::zeros(n, n);
            e[(i, j)] = 1.0;
            e[(j, i)] = 1.0;
            e
        })
        .collect();
    let trace: Vec<f64> = basis.iter().map(DMatrix::trace).collect();
    let decay = |a: &DMatrix<f64>| {
        let f = basis.iter().map(|e| -(a.transpose() * e + e * a)).collect();
        (-2.0 * &p, f)
    };
    let positive = (DMatrix::zeros(n, n), basis.clone());
    assert_optimum(&minimise(&trace, &[decay(&a), positive.clone()]), p.trace());
    let unstable = minimise(&trace, &[decay(&-a), positive]);
    assert_eq!(unstable.status, SolverStatus::PrimalInfeasible);
}
