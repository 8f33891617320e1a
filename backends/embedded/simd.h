#pragma once

// Lanes of doubles for the kernels. The file that includes this is compiled once for each
// instruction set; the macro POWDERCAL_ISA (portable, avx2, avx512) names the namespace, so that
// one program holds all of them. Every operation here rounds each lane as IEEE 754 says, and none
// is fused, so that results do not depend on the instruction set.

#include <cmath>
#include <cstdint>

#if defined(__AVX2__) || defined(__AVX512F__)
#include <immintrin.h>
#elif defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace powdercal::embedded::POWDERCAL_ISA {

#if defined(__AVX512F__)
inline constexpr int kLanes = 8;
#elif defined(__AVX2__)
inline constexpr int kLanes = 4;
#else
inline constexpr int kLanes = 2;
#endif

using Vec = double __attribute__((vector_size(8 * kLanes)));
using Row = double __attribute__((vector_size(32)));  // a row of four, e.g. x y z r

inline Vec Broadcast(double x) { return x - Vec{}; }
inline Vec Load(const double* p) { return *reinterpret_cast<const Vec*>(p); }
inline void Store(double* p, Vec v) { *reinterpret_cast<Vec*>(p) = v; }
inline Row LoadRow(const double* p) { return *reinterpret_cast<const Row*>(p); }
inline void StoreRow(double* p, Row v) { *reinterpret_cast<Row*>(p) = v; }

/// To the nearest integer, ties to even; |v| < 2^51.
inline Vec Round(Vec v) {
  constexpr double kMagic = 6755399441055744.0;  // 1.5 · 2^52
  return (v + kMagic) - kMagic;
}

#if defined(__AVX512F__)

inline Vec Sqrt(Vec v) { return _mm512_sqrt_pd(v); }
inline Vec Abs(Vec v) { return _mm512_abs_pd(v); }
inline Vec Max(Vec a, Vec b) { return _mm512_max_pd(a, b); }
inline Vec Min(Vec a, Vec b) { return _mm512_min_pd(a, b); }
/// a where x > y, else b.
inline Vec IfGreater(Vec x, Vec y, Vec a, Vec b) {
  return _mm512_mask_blend_pd(_mm512_cmp_pd_mask(x, y, _CMP_GT_OQ), b, a);
}
inline unsigned GreaterBits(Vec x, Vec y) { return _mm512_cmp_pd_mask(x, y, _CMP_GT_OQ); }

struct Columns {
  Vec x, y, z, w;
};

inline Columns Transpose(Row r0, Row r1, Row r2, Row r3, Row r4, Row r5, Row r6, Row r7) {
  const auto join = [](Row low, Row high) {
    return _mm512_insertf64x4(_mm512_castpd256_pd512(low), high, 1);
  };
  const __m512d a0 = join(r0, r2);
  const __m512d a1 = join(r1, r3);
  const __m512d a2 = join(r4, r6);
  const __m512d a3 = join(r5, r7);
  const __m512d t0 = _mm512_unpacklo_pd(a0, a1);
  const __m512d t1 = _mm512_unpackhi_pd(a0, a1);
  const __m512d t2 = _mm512_unpacklo_pd(a2, a3);
  const __m512d t3 = _mm512_unpackhi_pd(a2, a3);
  return {_mm512_shuffle_f64x2(t0, t2, 0x88), _mm512_shuffle_f64x2(t1, t3, 0x88),
          _mm512_shuffle_f64x2(t0, t2, 0xdd), _mm512_shuffle_f64x2(t1, t3, 0xdd)};
}

/// The rows base[index[lane] * stride …+3], as columns.
inline Columns Gather(const double* base, const std::int32_t* index, int stride) {
  const auto row = [&](int lane) {
    return LoadRow(base + static_cast<std::ptrdiff_t>(index[lane]) * stride);
  };
  return Transpose(row(0), row(1), row(2), row(3), row(4), row(5), row(6), row(7));
}

/// Rows of i less rows of j, as columns.
inline Columns GatherDifference(const double* base, const std::int32_t* i, const std::int32_t* j,
                                int stride) {
  const auto row = [&](int lane) {
    return LoadRow(base + static_cast<std::ptrdiff_t>(i[lane]) * stride) -
           LoadRow(base + static_cast<std::ptrdiff_t>(j[lane]) * stride);
  };
  return Transpose(row(0), row(1), row(2), row(3), row(4), row(5), row(6), row(7));
}

/// Rows (x, y, z, 0) of the lanes.
inline void ToRows(Vec x, Vec y, Vec z, Row* rows) {
  const __m512d zero = _mm512_setzero_pd();
  const __m512d t0 = _mm512_unpacklo_pd(x, y);
  const __m512d t1 = _mm512_unpackhi_pd(x, y);
  const __m512d u0 = _mm512_unpacklo_pd(z, zero);
  const __m512d u1 = _mm512_unpackhi_pd(z, zero);
  const __m512i low = _mm512_set_epi64(11, 10, 3, 2, 9, 8, 1, 0);
  const __m512i high = _mm512_set_epi64(15, 14, 7, 6, 13, 12, 5, 4);
  const auto store = [&](int first, __m512d pair) {
    rows[first] = _mm512_castpd512_pd256(pair);
    rows[first + 2] = _mm512_extractf64x4_pd(pair, 1);
  };
  store(0, _mm512_permutex2var_pd(t0, low, u0));
  store(1, _mm512_permutex2var_pd(t1, low, u1));
  store(4, _mm512_permutex2var_pd(t0, high, u0));
  store(5, _mm512_permutex2var_pd(t1, high, u1));
}

#elif defined(__AVX2__)

inline Vec Sqrt(Vec v) { return _mm256_sqrt_pd(v); }
inline Vec Abs(Vec v) { return _mm256_andnot_pd(_mm256_set1_pd(-0.0), v); }
inline Vec Max(Vec a, Vec b) { return _mm256_max_pd(a, b); }
inline Vec Min(Vec a, Vec b) { return _mm256_min_pd(a, b); }
inline Vec IfGreater(Vec x, Vec y, Vec a, Vec b) {
  return _mm256_blendv_pd(b, a, _mm256_cmp_pd(x, y, _CMP_GT_OQ));
}
inline unsigned GreaterBits(Vec x, Vec y) {
  return static_cast<unsigned>(_mm256_movemask_pd(_mm256_cmp_pd(x, y, _CMP_GT_OQ)));
}

struct Columns {
  Vec x, y, z, w;
};

inline Columns Transpose(Row r0, Row r1, Row r2, Row r3) {
  const __m256d t0 = _mm256_unpacklo_pd(r0, r1);
  const __m256d t1 = _mm256_unpackhi_pd(r0, r1);
  const __m256d t2 = _mm256_unpacklo_pd(r2, r3);
  const __m256d t3 = _mm256_unpackhi_pd(r2, r3);
  return {_mm256_permute2f128_pd(t0, t2, 0x20), _mm256_permute2f128_pd(t1, t3, 0x20),
          _mm256_permute2f128_pd(t0, t2, 0x31), _mm256_permute2f128_pd(t1, t3, 0x31)};
}

inline Columns Gather(const double* base, const std::int32_t* index, int stride) {
  const auto row = [&](int lane) {
    return LoadRow(base + static_cast<std::ptrdiff_t>(index[lane]) * stride);
  };
  return Transpose(row(0), row(1), row(2), row(3));
}

inline Columns GatherDifference(const double* base, const std::int32_t* i, const std::int32_t* j,
                                int stride) {
  const auto row = [&](int lane) {
    return LoadRow(base + static_cast<std::ptrdiff_t>(i[lane]) * stride) -
           LoadRow(base + static_cast<std::ptrdiff_t>(j[lane]) * stride);
  };
  return Transpose(row(0), row(1), row(2), row(3));
}

inline void ToRows(Vec x, Vec y, Vec z, Row* rows) {
  const __m256d zero = _mm256_setzero_pd();
  const __m256d t0 = _mm256_unpacklo_pd(x, y);
  const __m256d t1 = _mm256_unpackhi_pd(x, y);
  const __m256d u0 = _mm256_unpacklo_pd(z, zero);
  const __m256d u1 = _mm256_unpackhi_pd(z, zero);
  rows[0] = _mm256_permute2f128_pd(t0, u0, 0x20);
  rows[1] = _mm256_permute2f128_pd(t1, u1, 0x20);
  rows[2] = _mm256_permute2f128_pd(t0, u0, 0x31);
  rows[3] = _mm256_permute2f128_pd(t1, u1, 0x31);
}

#else

#if defined(__SSE2__)
inline Vec Sqrt(Vec v) { return _mm_sqrt_pd(v); }
inline Vec Abs(Vec v) { return _mm_andnot_pd(_mm_set1_pd(-0.0), v); }
inline Vec Max(Vec a, Vec b) { return _mm_max_pd(a, b); }
inline Vec Min(Vec a, Vec b) { return _mm_min_pd(a, b); }
inline Vec IfGreater(Vec x, Vec y, Vec a, Vec b) {
  const __m128d mask = _mm_cmpgt_pd(x, y);
  return _mm_or_pd(_mm_and_pd(mask, a), _mm_andnot_pd(mask, b));
}
inline unsigned GreaterBits(Vec x, Vec y) {
  return static_cast<unsigned>(_mm_movemask_pd(_mm_cmpgt_pd(x, y)));
}
#else
inline Vec Sqrt(Vec v) { return Vec{std::sqrt(v[0]), std::sqrt(v[1])}; }
inline Vec Abs(Vec v) { return Vec{std::abs(v[0]), std::abs(v[1])}; }
inline Vec IfGreater(Vec x, Vec y, Vec a, Vec b) {
  return Vec{x[0] > y[0] ? a[0] : b[0], x[1] > y[1] ? a[1] : b[1]};
}
inline Vec Max(Vec a, Vec b) { return IfGreater(a, b, a, b); }
inline Vec Min(Vec a, Vec b) { return IfGreater(b, a, a, b); }
inline unsigned GreaterBits(Vec x, Vec y) {
  return (x[0] > y[0] ? 1U : 0U) | (x[1] > y[1] ? 2U : 0U);
}
#endif

struct Columns {
  Vec x, y, z, w;
};

inline Columns Gather(const double* base, const std::int32_t* index, int stride) {
  const double* a = base + static_cast<std::ptrdiff_t>(index[0]) * stride;
  const double* b = base + static_cast<std::ptrdiff_t>(index[1]) * stride;
  return {Vec{a[0], b[0]}, Vec{a[1], b[1]}, Vec{a[2], b[2]}, Vec{a[3], b[3]}};
}

inline Columns GatherDifference(const double* base, const std::int32_t* i, const std::int32_t* j,
                                int stride) {
  const Columns a = Gather(base, i, stride);
  const Columns b = Gather(base, j, stride);
  return {a.x - b.x, a.y - b.y, a.z - b.z, a.w - b.w};
}

inline void ToRows(Vec x, Vec y, Vec z, Row* rows) {
  rows[0] = Row{x[0], y[0], z[0], 0};
  rows[1] = Row{x[1], y[1], z[1], 0};
}

#endif

}  // namespace powdercal::embedded::POWDERCAL_ISA
