// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/arm/arm_inverse.h"

#include "base/assertion.h"

#include <math.h>
#include <stddef.h>

#define DIRECTIONS 6U
#define FLOOR 1.0e-12 // Smallest pivot, which keeps the factors of a singular matrix positive.
// Steps of the inverse iteration; few are sufficient, because the singular values of an arm differ much.
#define ITERATIONS 6U

typedef struct { // J J^T or J^T J, whichever is smaller; their nonzero eigenvalues are the same.
    unsigned size;
    double at[DIRECTIONS][DIRECTIONS];
} square_t;

/// Compute the lower Cholesky factor of matrix + shift.
static void factorize(const square_t* const matrix, const double shift, square_t* const out_factor)
{
    out_factor->size = matrix->size;
    for (unsigned i = 0U; i < matrix->size; i++) {
        for (unsigned k = 0U; k <= i; k++) {
            double sum = matrix->at[i][k] + ((i == k) ? shift : 0.0);
            for (unsigned m = 0U; m < k; m++) {
                sum -= out_factor->at[i][m] * out_factor->at[k][m];
            }
            out_factor->at[i][k] =
                (i == k) ? sqrt((sum > FLOOR) ? sum : FLOOR) : (sum / out_factor->at[k][k]);
        }
    }
}

/// Solve factor factor^T x = x.
static void solve(const square_t* const factor, double x[DIRECTIONS])
{
    for (unsigned i = 0U; i < factor->size; i++) {
        for (unsigned k = 0U; k < i; k++) {
            x[i] -= factor->at[i][k] * x[k];
        }
        x[i] /= factor->at[i][i];
    }
    for (unsigned i = factor->size; i > 0U; i--) {
        for (unsigned k = i; k < factor->size; k++) {
            x[i - 1U] -= factor->at[k][i - 1U] * x[k];
        }
        x[i - 1U] /= factor->at[i - 1U][i - 1U];
    }
}

/// Estimate the smallest singular value of the Jacobian by inverse iteration; the estimate is not below the
/// true value.
static double smallest_singular_value(const square_t* const factor)
{
    // The start vector is not perpendicular to an axis of symmetry of an arm, so that the iteration finds
    // every direction.
    static const double start[DIRECTIONS] = {0.51, -0.43, 0.37, 0.31, -0.41, 0.39};
    double x[DIRECTIONS];
    double growth = 1.0;
    for (unsigned i = 0U; i < DIRECTIONS; i++) {
        x[i] = start[i];
    }
    for (unsigned round = 0U; round < ITERATIONS; round++) {
        double square = 0.0;
        for (unsigned i = 0U; i < factor->size; i++) {
            square += x[i] * x[i];
        }
        growth = sqrt(square);
        for (unsigned i = 0U; i < factor->size; i++) {
            x[i] /= growth;
        }
        solve(factor, x);
    }
    double square = 0.0;
    for (unsigned i = 0U; i < factor->size; i++) {
        square += x[i] * x[i];
    }
    return 1.0 / sqrt(sqrt(square));
}

typedef struct {
    const arm_jacobian_t* jacobian;
    unsigned directions; // Number of rows of the Jacobian that are used.
    unsigned joint_count;
    bool is_wide; // There are at least as many joints as directions.
} problem_t;

/// Returns an element of J J^T or J^T J.
static double element(const problem_t* const problem, const unsigned row, const unsigned column)
{
    const arm_jacobian_t* const jacobian = problem->jacobian;
    const unsigned terms                 = problem->is_wide ? problem->joint_count : problem->directions;
    double sum                           = 0.0;
    for (unsigned i = 0U; i < terms; i++) {
        sum += problem->is_wide ? (jacobian->at[row][i] * jacobian->at[column][i])
                                : (jacobian->at[i][row] * jacobian->at[i][column]);
    }
    return sum;
}

/// Multiply the transposed Jacobian by a vector.
static void transposed_times(const problem_t* const problem, const double direction[DIRECTIONS],
                             double* const out)
{
    for (unsigned i = 0U; i < problem->joint_count; i++) {
        out[i] = 0.0;
        for (unsigned k = 0U; k < problem->directions; k++) {
            out[i] += problem->jacobian->at[k][i] * direction[k];
        }
    }
}

double arm_inverse(const arm_inverse_t* const settings, const arm_jacobian_t* const jacobian,
                   const unsigned joint_count, const arm_twist_t* const twist,
                   double out_rate_rad_s[ARM_JOINTS_MAX])
{
    FSW_ASSERT((settings != NULL) && (jacobian != NULL) && (twist != NULL));
    const unsigned directions = settings->is_position_only ? 3U : DIRECTIONS;
    const problem_t problem   = {.jacobian    = jacobian,
                                 .directions  = directions,
                                 .joint_count = joint_count,
                                 .is_wide     = (joint_count >= directions)};
    square_t matrix           = {.size = problem.is_wide ? directions : joint_count};
    for (unsigned i = 0U; i < matrix.size; i++) {
        for (unsigned k = 0U; k <= i; k++) {
            matrix.at[i][k] = element(&problem, i, k);
        }
    }
    square_t factor;
    factorize(&matrix, 0.0, &factor);
    const double smallest = smallest_singular_value(&factor);
    if (smallest < settings->limit) {
        const double share = 1.0 - (smallest / settings->limit);
        const double damp  = settings->damping * share;
        factorize(&matrix, damp * damp, &factor);
    }
    double wanted[DIRECTIONS];
    for (unsigned i = 0U; i < 3U; i++) {
        wanted[i]      = twist->linear_m_s.at[i];
        wanted[i + 3U] = twist->angular_rad_s.at[i];
    }
    if (problem.is_wide) { // J^T (J J^T + d^2)^-1
        solve(&factor, wanted);
        transposed_times(&problem, wanted, out_rate_rad_s);
    } else { // (J^T J + d^2)^-1 J^T
        double rates[DIRECTIONS];
        transposed_times(&problem, wanted, rates);
        solve(&factor, rates);
        for (unsigned i = 0U; i < joint_count; i++) {
            out_rate_rad_s[i] = rates[i];
        }
    }
    return smallest;
}
