/** Spectra: a Fourier transform of radix 2 and a Hann window. */

/** The transform in place; both arrays have the same length, a power of two. */
export function transform(real, imaginary) {
  const size = real.length;
  if (size < 1 || (size & (size - 1)) !== 0 || imaginary.length !== size) {
    throw new RangeError(`two arrays of the same power of two, got ${size}, ${imaginary.length}`);
  }
  for (let n = 1, swapped = 0; n < size; n += 1) {
    let bit = size >> 1;
    for (; swapped & bit; bit >>= 1) swapped ^= bit;
    swapped ^= bit;
    if (n < swapped) {
      [real[n], real[swapped]] = [real[swapped], real[n]];
      [imaginary[n], imaginary[swapped]] = [imaginary[swapped], imaginary[n]];
    }
  }
  for (let length = 2; length <= size; length *= 2) {
    const half = length / 2;
    for (let k = 0; k < half; k += 1) {
      const angle = (-2 * Math.PI * k) / length;
      const [c, s] = [Math.cos(angle), Math.sin(angle)];
      for (let a = k; a < size; a += length) {
        const b = a + half;
        const x = real[b] * c - imaginary[b] * s;
        const y = real[b] * s + imaginary[b] * c;
        real[b] = real[a] - x;
        imaginary[b] = imaginary[a] - y;
        real[a] += x;
        imaginary[a] += y;
      }
    }
  }
}

const MOST = 1 << 15;

/**
 * Amplitudes (those of sines, peak) over frequencies in Hz of the newest rows without a gap: as
 * many as a power of two has room for. The mean is taken off first. Empty for less than 16 rows.
 */
export function spectrum(values, step) {
  let begin = values.length;
  while (begin > 0 && Number.isFinite(values[begin - 1])) begin -= 1;
  const there = Math.min(values.length - begin, MOST);
  const size = 2 ** Math.floor(Math.log2(Math.max(there, 1)));
  if (size < 16 || !(step > 0)) return [[], []];
  const real = Float64Array.from(values.subarray(values.length - size));
  const mean = real.reduce((sum, value) => sum + value, 0) / size;
  let weight = 0;
  for (let n = 0; n < size; n += 1) {
    const hann = 0.5 - 0.5 * Math.cos((2 * Math.PI * n) / size);
    weight += hann;
    real[n] = (real[n] - mean) * hann;
  }
  const imaginary = new Float64Array(size);
  transform(real, imaginary);
  const [frequencies, amplitudes] = [[], []];
  for (let n = 0; n < size / 2; n += 1) {
    frequencies.push(n / (size * step));
    amplitudes.push((n ? 2 : 1) * Math.hypot(real[n], imaginary[n]) / weight);
  }
  return [frequencies, amplitudes];
}
