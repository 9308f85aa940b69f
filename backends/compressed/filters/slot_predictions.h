// backends/compressed/filters/slot_predictions.h: predicts the vertices of a slot from the points
// of edge_lattice.h, row by row, and turns numbers into residuals (residuals.h) and back. Each call
// uses the best instruction set of the processor; all sets write the same bytes.
// docs/filters/hierarchy.md and normals.md have the formulas. Pinned by
// tests/backends/compressed/filters/hierarchy_filter_test.cpp.
#pragma once

#include <cstdint>

#include "plait/detail/namespace.h"
#include "plait/detail/slot_shapes.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE

enum class PredictionRule : std::uint8_t { kButterfly, kLoop, kMidpoint };
constexpr int kPredictionRules = 3;

/// The points around an edge, and the rows of its slot that are predicted from them. The vertex
/// (row, column) lies between the points (row, column + 1) and (row + 1, column). Numbers,
/// residuals and predictions are those of the slot, from its first record on.
template <class Number>
struct PredictedRows {
  const Number* points;     ///< the point (0, 0)
  std::int64_t stride;      ///< numbers from (p, q) to (p + 1, q)
  std::int64_t side;        ///< rows of the slot
  std::int64_t components;  ///< numbers in a record
  SlotRows slot;  ///< the length of the rows, and whether the last records lie on a border
  PredictionRule rule;
};

enum class Recode : std::uint8_t {
  kEncode,  ///< from numbers, given as their bits, to residuals
  kDecode,  ///< and back
};
void recode_rows(const PredictedRows<float>& rows, const std::uint32_t* from, std::uint32_t* to,
                 Recode recode);
void recode_rows(const PredictedRows<double>& rows, const std::uint64_t* from, std::uint64_t* to,
                 Recode recode);
void predict_rows(const PredictedRows<float>& rows, float* predictions);
void predict_rows(const PredictedRows<double>& rows, double* predictions);

/// Records of 3 numbers: the residuals of two components count from where the
/// third one says that the vertex lies, if it was moved along the normal. `predictions` are those
/// of predict_rows(). Slopes steeper than kSteepestSlope are not followed.
constexpr int kSteepestSlope = 4;
void recode_along_normals(const PredictedRows<float>& rows, const float* predictions,
                          const std::uint32_t* from, std::uint32_t* to, Recode recode);
void recode_along_normals(const PredictedRows<double>& rows, const double* predictions,
                          const std::uint64_t* from, std::uint64_t* to, Recode recode);

/// The points around an edge, two steps between neighbouring vertices: the vertex (row, column) is
/// the point (2 row + 1, 2 column + 1).
template <class Real>
struct NormalRows {
  const Real* points;   ///< the point (0, 0)
  std::int64_t stride;  ///< numbers from (p, q) to (p + 1, q)
  std::int64_t side;    ///< rows of the slot
  SlotRows slot;        ///< as in PredictedRows
  float* predictions;   ///< room for the normals of one row
};

void recode_normals(const NormalRows<float>& rows, const std::uint32_t* from, std::uint32_t* to,
                    Recode recode);
void recode_normals(const NormalRows<double>& rows, const std::uint32_t* from, std::uint32_t* to,
                    Recode recode);

PLAIT_END_NAMESPACE
