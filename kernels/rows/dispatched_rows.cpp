#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "rows/dispatched_rows.cpp"
#include "rows/dispatched_rows.h"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "rows/butterfly_rows-inl.h"
#include "rows/normal_rows-inl.h"
#include "rows/one_ring_rows-inl.h"
#include "rows/record_normals-inl.h"
#include "schemes/loop.h"
#include "schemes/midpoint.h"

HWY_BEFORE_NAMESPACE();
namespace plait::fused_rows::HWY_NAMESPACE {

void loop_float(OneRingFunctions<float>& functions) { put_rows<LoopRule>(functions); }
void loop_double(OneRingFunctions<double>& functions) { put_rows<LoopRule>(functions); }
void midpoint_float(OneRingFunctions<float>& functions) { put_rows<MidpointRule>(functions); }
void midpoint_double(OneRingFunctions<double>& functions) { put_rows<MidpointRule>(functions); }
ButterflyRows<float> butterfly_float() { return butterfly_rows<float>(); }
ButterflyRows<double> butterfly_double() { return butterfly_rows<double>(); }
NormalRow<float> normal_float() { return normal_row<float>; }
NormalRow<double> normal_double() { return normal_row<double>; }
RecordNormalsRow<float> record_float() { return record_row<float>; }
RecordNormalsRow<double> record_double() { return record_row<double>; }

}  // namespace plait::fused_rows::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace plait::fused_rows {

HWY_EXPORT(loop_float);
HWY_EXPORT(loop_double);
HWY_EXPORT(midpoint_float);
HWY_EXPORT(midpoint_double);
HWY_EXPORT(butterfly_float);
HWY_EXPORT(butterfly_double);
HWY_EXPORT(normal_float);
HWY_EXPORT(normal_double);
HWY_EXPORT(record_float);
HWY_EXPORT(record_double);

}  // namespace plait::fused_rows

PLAIT_BEGIN_PRIVATE_NAMESPACE

using namespace fused_rows;

template <>
void choose_rows<LoopRule>(OneRingFunctions<float>& functions) {
  HWY_DYNAMIC_DISPATCH(loop_float)(functions);
}
template <>
void choose_rows<LoopRule>(OneRingFunctions<double>& functions) {
  HWY_DYNAMIC_DISPATCH(loop_double)(functions);
}
template <>
void choose_rows<MidpointRule>(OneRingFunctions<float>& functions) {
  HWY_DYNAMIC_DISPATCH(midpoint_float)(functions);
}
template <>
void choose_rows<MidpointRule>(OneRingFunctions<double>& functions) {
  HWY_DYNAMIC_DISPATCH(midpoint_double)(functions);
}
template <>
ButterflyRows<float> butterfly_rows() {
  return HWY_DYNAMIC_DISPATCH(butterfly_float)();
}
template <>
ButterflyRows<double> butterfly_rows() {
  return HWY_DYNAMIC_DISPATCH(butterfly_double)();
}
template <>
NormalRow<float> normal_row() {
  return HWY_DYNAMIC_DISPATCH(normal_float)();
}
template <>
NormalRow<double> normal_row() {
  return HWY_DYNAMIC_DISPATCH(normal_double)();
}
template <>
RecordNormalsRow<float> record_normals_row() {
  return HWY_DYNAMIC_DISPATCH(record_float)();
}
template <>
RecordNormalsRow<double> record_normals_row() {
  return HWY_DYNAMIC_DISPATCH(record_double)();
}

PLAIT_END_NAMESPACE
#endif
