#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "compressed/filters/slot_predictions.cpp"
#include "compressed/filters/slot_predictions.h"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "compressed/filters/along_normals-inl.h"
#include "compressed/filters/predicted_normals-inl.h"
#include "compressed/filters/predicted_rows-inl.h"

#if HWY_ONCE
namespace plait::slot_predictions {

HWY_EXPORT(recode_floats);
HWY_EXPORT(recode_doubles);
HWY_EXPORT(predict_floats);
HWY_EXPORT(predict_doubles);
HWY_EXPORT(floats_along);
HWY_EXPORT(doubles_along);
HWY_EXPORT(normals_from_floats);
HWY_EXPORT(normals_from_doubles);

}  // namespace plait::slot_predictions

PLAIT_BEGIN_PRIVATE_NAMESPACE

using namespace slot_predictions;

void recode_rows(const PredictedRows<float>& rows, const std::uint32_t* from, std::uint32_t* to,
                 Recode recode) {
  HWY_DYNAMIC_DISPATCH(recode_floats)(rows, from, to, recode);
}
void recode_rows(const PredictedRows<double>& rows, const std::uint64_t* from, std::uint64_t* to,
                 Recode recode) {
  HWY_DYNAMIC_DISPATCH(recode_doubles)(rows, from, to, recode);
}
void predict_rows(const PredictedRows<float>& rows, float* predictions) {
  HWY_DYNAMIC_DISPATCH(predict_floats)(rows, predictions);
}
void predict_rows(const PredictedRows<double>& rows, double* predictions) {
  HWY_DYNAMIC_DISPATCH(predict_doubles)(rows, predictions);
}
void recode_along_normals(const PredictedRows<float>& rows, const float* predictions,
                          const std::uint32_t* from, std::uint32_t* to, Recode recode) {
  HWY_DYNAMIC_DISPATCH(floats_along)(rows, predictions, from, to, recode);
}
void recode_along_normals(const PredictedRows<double>& rows, const double* predictions,
                          const std::uint64_t* from, std::uint64_t* to, Recode recode) {
  HWY_DYNAMIC_DISPATCH(doubles_along)(rows, predictions, from, to, recode);
}
void recode_normals(const NormalRows<float>& rows, const std::uint32_t* from, std::uint32_t* to,
                    Recode recode) {
  HWY_DYNAMIC_DISPATCH(normals_from_floats)(rows, from, to, recode);
}
void recode_normals(const NormalRows<double>& rows, const std::uint32_t* from, std::uint32_t* to,
                    Recode recode) {
  HWY_DYNAMIC_DISPATCH(normals_from_doubles)(rows, from, to, recode);
}

PLAIT_END_NAMESPACE
#endif  // HWY_ONCE
