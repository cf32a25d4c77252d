//! A minimum subject to matrix inequalities, by the interior-point solver.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, SolverError, SolverStatus, SupportedConeT,
};

use crate::lmi::affine::{Affine, Variables};
use crate::lmi::matrix::{Matrix, smallest_eigenvalue};

/// What the solver found.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The solver's own verdict: not a proof.
    pub status: SolverStatus,
    /// Interior-point iterations.
    pub iterations: u32,
    /// One number for each decision variable.
    pub x: Vec<f64>,
}

impl Solution {
    /// Whether x is worth checking.
    pub fn is_candidate(&self) -> bool {
        matches!(self.status, SolverStatus::Solved | SolverStatus::AlmostSolved)
            && self.x.iter().all(|x| x.is_finite())
    }
}

/// Minimises the scalar `objective` over all `variables` subject to `X >= 0` for every X in
/// `inequalities`.
///
/// Runs on one thread and gives the same bits for the same input.
///
/// # Errors
/// The solver refuses the problem's form.
pub fn minimise(
    variables: &Variables,
    objective: &Affine,
    inequalities: &[Affine],
) -> Result<Solution, SolverError> {
    // The solver's form: minimise q'x subject to s = b - A x, s in the cones. A semidefinite cone
    // holds svec(X): the upper triangle by columns, off-diagonal elements times sqrt(2).
    let mut columns: Vec<Vec<(usize, f64)>> = vec![Vec::new(); variables.count];
    let mut b = Vec::new();
    let mut cones = Vec::new();
    for inequality in inequalities {
        let first_row = b.len();
        b.extend(svec(&inequality.constant));
        for (&j, term) in &inequality.terms {
            let elements = svec(term).enumerate().filter(|&(_, element)| element != 0.0);
            columns[j].extend(elements.map(|(row, element)| (first_row + row, -element)));
        }
        cones.push(SupportedConeT::PSDTriangleConeT(inequality.order()));
    }
    let mut column_starts = vec![0];
    for column in &columns {
        column_starts.push(column_starts[column_starts.len() - 1] + column.len());
    }
    let (rows, values) = columns.into_iter().flatten().unzip();
    let a = CscMatrix::new(b.len(), variables.count, column_starts, rows, values);
    let mut q = vec![0.0; variables.count];
    for (&j, term) in &objective.terms {
        q[j] = term[0];
    }

    let settings = DefaultSettings {
        verbose: false,
        max_threads: 1,
        chordal_decomposition_enable: false,
        ..DefaultSettings::default()
    };
    let no_quadratic_part = CscMatrix::zeros((variables.count, variables.count));
    let mut solver = DefaultSolver::new(&no_quadratic_part, &q, &a, &b, &cones, settings)?;
    solver.solve();
    Ok(Solution {
        status: solver.solution.status,
        iterations: solver.solution.iterations,
        x: solver.solution.x,
    })
}

/// Inequalities added in a round of [`minimise_with_cuts`].
const CUTS: usize = 48;
/// Its rounds at most.
const ROUNDS: usize = 40;

/// As [`minimise`], subject to `inequalities` and `further` ones, which are added only once a
/// solution without them misses them by more than `accepted`, the most missed first: of many similar
/// inequalities few matter at the optimum. A solution satisfies them all.
///
/// # Errors
/// As [`minimise`].
pub fn minimise_with_cuts(
    variables: &Variables,
    objective: &Affine,
    mut inequalities: Vec<Affine>,
    mut further: Vec<Affine>,
    accepted: f64,
) -> Result<Solution, SolverError> {
    let mut iterations = 0;
    for _ in 0..ROUNDS {
        let mut solution = minimise(variables, objective, &inequalities)?;
        iterations += solution.iterations;
        solution.iterations = iterations;
        if !solution.is_candidate() {
            return Ok(solution);
        }
        let mut missed: Vec<(f64, usize)> = further
            .iter()
            .enumerate()
            .map(|(index, x)| (smallest_eigenvalue(&x.at(&solution.x)), index))
            .filter(|&(eigenvalue, _)| eigenvalue < -accepted)
            .collect();
        if missed.is_empty() {
            return Ok(solution);
        }
        missed.sort_by(|a, b| a.0.total_cmp(&b.0));
        missed.truncate(CUTS);
        // From the back, so that places before stay what they are.
        missed.sort_by_key(|&(_, index)| std::cmp::Reverse(index));
        inequalities.extend(missed.into_iter().map(|(_, index)| further.swap_remove(index)));
    }
    // Too many rounds: all at once.
    inequalities.append(&mut further);
    minimise(variables, objective, &inequalities)
}

/// The upper triangle of a symmetric matrix by columns, off-diagonal elements times sqrt(2): the
/// inner product of matrices becomes that of vectors.
fn svec(x: &Matrix) -> impl Iterator<Item = f64> + '_ {
    (0..x.ncols()).flat_map(move |column| {
        (0..=column).map(move |row| {
            let element = x[(row, column)];
            if row == column { element } else { std::f64::consts::SQRT_2 * element }
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix<const R: usize, const K: usize>(rows: [[f64; K]; R]) -> Matrix {
        Matrix::from_fn(R, K, |i, j| rows[i][j])
    }

    #[test]
    fn expressions_obey_matrix_algebra_at_every_point() {
        let mut variables = Variables::default();
        let (r, s) = (variables.full(2, 2), variables.symmetric(2));
        let a = matrix([[1.0, 2.0], [3.0, 5.0]]);
        let x: Vec<f64> = (0..7).map(|j| 0.3 * f64::from(j) - 1.0).collect();

        let expression = Affine::blocks([[(&r * &a).he() - &s, &(&a * 2.0) * &r]]);

        let (r, s) = (r.at(&x), s.at(&x));
        assert_eq!(s, s.transpose());
        let left = &r * &a + (&r * &a).transpose() - &s;
        let right = &a * 2.0 * &r;
        let mut expected = Matrix::zeros(2, 4);
        expected.view_mut((0, 0), (2, 2)).copy_from(&left);
        expected.view_mut((0, 2), (2, 2)).copy_from(&right);
        assert!((expression.at(&x) - expected).amax() < 1e-14);
    }

    #[test]
    fn svec_keeps_the_inner_product() {
        let a = matrix([[1.0, 2.0, 0.5], [2.0, -1.0, 3.0], [0.5, 3.0, 4.0]]);
        let b = matrix([[0.0, 1.5, 2.5], [1.5, 2.0, -3.0], [2.5, -3.0, 1.0]]);
        let product: f64 = svec(&a).zip(svec(&b)).map(|(a, b)| a * b).sum();
        assert!((product - (&a * &b).trace()).abs() < 1e-13);
    }

    #[test]
    fn smallest_t_with_t_identity_above_a_matrix_is_its_largest_eigenvalue() {
        let a = matrix([[2.0, 1.0], [1.0, 3.0]]);
        let mut variables = Variables::default();
        let t = variables.scalar();
        let inequality = t.times_identity(2) - Affine::from(a.clone());
        let solution = minimise(&variables, &t, &[inequality]).unwrap();
        assert_eq!(solution.status, SolverStatus::Solved);
        assert!((solution.x[0] - a.symmetric_eigenvalues().max()).abs() < 1e-7);
    }

    #[test]
    fn contradicting_inequalities_are_infeasible() {
        let mut variables = Variables::default();
        let t = variables.scalar();
        let solution = minimise(&variables, &t, &[&t - &Affine::number(1.0), -&t]).unwrap();
        assert_eq!(solution.status, SolverStatus::PrimalInfeasible);
        assert!(!solution.is_candidate());
    }
}
