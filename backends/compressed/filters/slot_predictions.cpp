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

HWY_EXPORT(encode_floats);
HWY_EXPORT(encode_doubles);
HWY_EXPORT(decode_floats);
HWY_EXPORT(decode_doubles);
HWY_EXPORT(predict_floats);
HWY_EXPORT(predict_doubles);
HWY_EXPORT(floats_along);
HWY_EXPORT(doubles_along);
HWY_EXPORT(encode_from_floats);
HWY_EXPORT(encode_from_doubles);
HWY_EXPORT(decode_from_floats);
HWY_EXPORT(decode_from_doubles);

}  // namespace plait::slot_predictions

PLAIT_BEGIN_PRIVATE_NAMESPACE

using namespace slot_predictions;

void encode_rows(const PredictedRows<float>& rows, const float* numbers, std::uint32_t* residuals) {
  HWY_DYNAMIC_DISPATCH(encode_floats)(rows, numbers, residuals);
}
void encode_rows(const PredictedRows<double>& rows, const double* numbers,
                 std::uint64_t* residuals) {
  HWY_DYNAMIC_DISPATCH(encode_doubles)(rows, numbers, residuals);
}
void decode_rows(const PredictedRows<float>& rows, const std::uint32_t* residuals, float* numbers) {
  HWY_DYNAMIC_DISPATCH(decode_floats)(rows, residuals, numbers);
}
void decode_rows(const PredictedRows<double>& rows, const std::uint64_t* residuals,
                 double* numbers) {
  HWY_DYNAMIC_DISPATCH(decode_doubles)(rows, residuals, numbers);
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
void encode_normals(const NormalRows<float>& rows, const float* normals, std::uint32_t* residuals) {
  HWY_DYNAMIC_DISPATCH(encode_from_floats)(rows, normals, residuals);
}
void encode_normals(const NormalRows<double>& rows, const float* normals,
                    std::uint32_t* residuals) {
  HWY_DYNAMIC_DISPATCH(encode_from_doubles)(rows, normals, residuals);
}
void decode_normals(const NormalRows<float>& rows, const std::uint32_t* residuals, float* normals) {
  HWY_DYNAMIC_DISPATCH(decode_from_floats)(rows, residuals, normals);
}
void decode_normals(const NormalRows<double>& rows, const std::uint32_t* residuals,
                    float* normals) {
  HWY_DYNAMIC_DISPATCH(decode_from_doubles)(rows, residuals, normals);
}

PLAIT_END_NAMESPACE
#endif  // HWY_ONCE
