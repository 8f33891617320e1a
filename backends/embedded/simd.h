#pragma once

// Lanes of doubles for the kernels. The file that includes this is compiled once for each
// instruction set; the macro POWDERCAL_ISA (portable, avx2, avx512) names the namespace, so that
// one program holds all of them. Every operation here rounds each lane as IEEE 754 says, and none
// is fused, so that results do not depend on the instruction set.

#include <cmath>
#include <cstdint>

#include "backends/embedded/kernels.h"

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

struct Columns {
  Vec x, y, z, w;
};

/// Of pairs of particles i and j, lane by lane.
struct PairRows {
  Columns position;  // of i less that of j; w: ri − rj
  Columns velocity;
  Columns spin_i;
  Columns spin_j;
};

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

inline Vec Join(Row low, Row high) {
  return _mm512_insertf64x4(_mm512_castpd256_pd512(low), high, 1);
}

// Of the rows of lanes (0, 2), (1, 3), (4, 6), (5, 7).
inline Columns Transpose(const Vec (&a)[4]) {
  const __m512d t0 = _mm512_unpacklo_pd(a[0], a[1]);
  const __m512d t1 = _mm512_unpackhi_pd(a[0], a[1]);
  const __m512d t2 = _mm512_unpacklo_pd(a[2], a[3]);
  const __m512d t3 = _mm512_unpackhi_pd(a[2], a[3]);
  return {_mm512_shuffle_f64x2(t0, t2, 0x88), _mm512_shuffle_f64x2(t1, t3, 0x88),
          _mm512_shuffle_f64x2(t0, t2, 0xdd), _mm512_shuffle_f64x2(t1, t3, 0xdd)};
}

/// The rows at base + index[lane], as columns.
inline Columns Gather(const double* base, const Offset* index) {
  const auto row = [&](int lane) { return LoadRow(base + index[lane]); };
  const Vec a[4] = {Join(row(0), row(2)), Join(row(1), row(3)), Join(row(4), row(6)),
                    Join(row(5), row(7))};
  return Transpose(a);
}

/// A particle at a time, so that its address is needed once.
inline PairRows GatherPairs(const double* rows, const Offset* i, const Offset* j) {
  Vec d[4];
  Vec v[4];
  Vec wi[4];
  Vec wj[4];
  constexpr int kLane[4] = {0, 1, 4, 5};
  for (int g = 0; g < 4; ++g) {
    const double* a = rows + i[kLane[g]];
    const double* b = rows + j[kLane[g]];
    const double* c = rows + i[kLane[g] + 2];
    const double* e = rows + j[kLane[g] + 2];
    d[g] = Join(LoadRow(a) - LoadRow(b), LoadRow(c) - LoadRow(e));
    v[g] = Join(LoadRow(a + kVelocity) - LoadRow(b + kVelocity),
                LoadRow(c + kVelocity) - LoadRow(e + kVelocity));
    wi[g] = Join(LoadRow(a + kSpin), LoadRow(c + kSpin));
    wj[g] = Join(LoadRow(b + kSpin), LoadRow(e + kSpin));
  }
  return {Transpose(d), Transpose(v), Transpose(wi), Transpose(wj)};
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

inline Columns Transpose(Row r0, Row r1, Row r2, Row r3) {
  const __m256d t0 = _mm256_unpacklo_pd(r0, r1);
  const __m256d t1 = _mm256_unpackhi_pd(r0, r1);
  const __m256d t2 = _mm256_unpacklo_pd(r2, r3);
  const __m256d t3 = _mm256_unpackhi_pd(r2, r3);
  return {_mm256_permute2f128_pd(t0, t2, 0x20), _mm256_permute2f128_pd(t1, t3, 0x20),
          _mm256_permute2f128_pd(t0, t2, 0x31), _mm256_permute2f128_pd(t1, t3, 0x31)};
}

inline Columns Gather(const double* base, const Offset* index) {
  const auto row = [&](int lane) { return LoadRow(base + index[lane]); };
  return Transpose(row(0), row(1), row(2), row(3));
}

inline PairRows GatherPairs(const double* rows, const Offset* i, const Offset* j) {
  Row d[4];
  Row v[4];
  Row wi[4];
  Row wj[4];
  for (int lane = 0; lane < 4; ++lane) {
    const double* a = rows + i[lane];
    const double* b = rows + j[lane];
    d[lane] = LoadRow(a) - LoadRow(b);
    v[lane] = LoadRow(a + kVelocity) - LoadRow(b + kVelocity);
    wi[lane] = LoadRow(a + kSpin);
    wj[lane] = LoadRow(b + kSpin);
  }
  return {Transpose(d[0], d[1], d[2], d[3]), Transpose(v[0], v[1], v[2], v[3]),
          Transpose(wi[0], wi[1], wi[2], wi[3]), Transpose(wj[0], wj[1], wj[2], wj[3])};
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

inline Columns Gather(const double* base, const Offset* index) {
  const double* a = base + index[0];
  const double* b = base + index[1];
  return {Vec{a[0], b[0]}, Vec{a[1], b[1]}, Vec{a[2], b[2]}, Vec{a[3], b[3]}};
}

inline PairRows GatherPairs(const double* rows, const Offset* i, const Offset* j) {
  const auto difference = [](const Columns& a, const Columns& b) {
    return Columns{a.x - b.x, a.y - b.y, a.z - b.z, a.w - b.w};
  };
  return {difference(Gather(rows, i), Gather(rows, j)),
          difference(Gather(rows + kVelocity, i), Gather(rows + kVelocity, j)),
          Gather(rows + kSpin, i), Gather(rows + kSpin, j)};
}

inline void ToRows(Vec x, Vec y, Vec z, Row* rows) {
  rows[0] = Row{x[0], y[0], z[0], 0};
  rows[1] = Row{x[1], y[1], z[1], 0};
}

#endif

}  // namespace powdercal::embedded::POWDERCAL_ISA
