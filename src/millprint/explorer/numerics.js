/* Linear algebra and the normal distribution, as far as Gaussian processes need them. */

/** Lower Cholesky factor of a symmetric positive definite matrix, both as arrays of rows. */
function cholesky(matrix) {
  const size = matrix.length;
  const factor = matrix.map(() => new Float64Array(size));
  for (let i = 0; i < size; i += 1) {
    for (let j = 0; j <= i; j += 1) {
      let sum = matrix[i][j];
      for (let k = 0; k < j; k += 1) sum -= factor[i][k] * factor[j][k];
      if (i === j) {
        if (!(sum > 0)) throw new Error(`covariance is not positive definite at row ${i + 1}`);
        factor[i][i] = Math.sqrt(sum);
      } else {
        factor[i][j] = sum / factor[j][j];
      }
    }
  }
  return factor;
}

/** x of L x = b for a lower factor L. */
function solveLower(factor, right) {
  const found = new Float64Array(right.length);
  for (let i = 0; i < right.length; i += 1) {
    let sum = right[i];
    for (let k = 0; k < i; k += 1) sum -= factor[i][k] * found[k];
    found[i] = sum / factor[i][i];
  }
  return found;
}

/** x of L' x = b for a lower factor L. */
function solveUpper(factor, right) {
  const found = Float64Array.from(right);
  for (let i = right.length - 1; i >= 0; i -= 1) {
    let sum = found[i];
    for (let k = i + 1; k < right.length; k += 1) sum -= factor[k][i] * found[k];
    found[i] = sum / factor[i][i];
  }
  return found;
}

/** x of L L' x = b for a lower factor L. */
function solveFactored(factor, right) {
  return solveUpper(factor, solveLower(factor, right));
}

function dot(left, right) {
  let sum = 0;
  for (let i = 0; i < left.length; i += 1) sum += left[i] * right[i];
  return sum;
}

/** P(Z <= x) of a standard normal variable, to 1e-14: a series within 3.5, a continued fraction beyond. */
function normalCdf(x) {
  const z = Math.abs(x) / Math.SQRT2;
  let tail;
  if (z < 2.5) {
    let term = z;
    let sum = z;
    for (let n = 1; term > 1e-17 * sum; n += 1) {
      term *= (2 * z * z) / (2 * n + 1);
      sum += term;
    }
    tail = 0.5 - (Math.exp(-z * z) * sum) / Math.sqrt(Math.PI);
  } else {
    let fraction = z;
    for (let n = 80; n >= 1; n -= 1) fraction = z + n / 2 / fraction;
    tail = Math.exp(-z * z) / fraction / Math.sqrt(Math.PI) / 2;
  }
  return x > 0 ? 1 - tail : tail;
}

/** The nearest whole number; of two equally near numbers the even one, as in Python. */
function roundHalfEven(x) {
  const floor = Math.floor(x);
  if (x - floor !== 0.5) return Math.round(x);
  return floor % 2 === 0 ? floor : floor + 1;
}

/** `count` numbers from `low` to `high` at equal distances, or at equal ratios. */
function linspace(low, high, count) {
  if (count === 1) return [low];
  return Array.from({ length: count }, (_, i) => low + ((high - low) * i) / (count - 1));
}

function geomspace(low, high, count) {
  return linspace(Math.log(low), Math.log(high), count).map(Math.exp);
}
