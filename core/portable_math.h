#pragma once

namespace powdercal {

// Elementary functions from IEEE additions, multiplications, divisions and square roots alone, so
// that drawn sizes, box heights and with them program hashes are the same on every platform;
// library mathematics may differ in the last digit. See also PortableLog and NormalQuantile in
// random.h.

/// e^x; relative error below 4e-16 where the result is a normal number.
double PortableExp(double x);

/// Density of the standard normal distribution; relative error about (1 + z²)·2e-16.
double PortableNormalDensity(double z);

/// Standard normal distribution function, also accurate where it is tiny: relative error below
/// 2e-14 for z > −8. For the upper tail use PortableNormalCdf(−z).
double PortableNormalCdf(double z);

}  // namespace powdercal
