#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fused/builtin_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "fused/butterfly_rows-inl.h"
#include "fused/patch_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace plait::fused_rows::HWY_NAMESPACE {

OneRingRows<float> loop_float() { return one_ring_rows<LoopRule, float>(); }
OneRingRows<double> loop_double() { return one_ring_rows<LoopRule, double>(); }
OneRingRows<float> midpoint_float() { return one_ring_rows<MidpointRule, float>(); }
OneRingRows<double> midpoint_double() { return one_ring_rows<MidpointRule, double>(); }
ButterflyRows<float> butterfly_float() { return butterfly_rows<float>(); }
ButterflyRows<double> butterfly_double() { return butterfly_rows<double>(); }

}  // namespace plait::fused_rows::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include "fused/builtin_rows.h"

namespace plait {
namespace fused_rows {

HWY_EXPORT(loop_float);
HWY_EXPORT(loop_double);
HWY_EXPORT(midpoint_float);
HWY_EXPORT(midpoint_double);
HWY_EXPORT(butterfly_float);
HWY_EXPORT(butterfly_double);

}  // namespace fused_rows

template <>
fused_rows::OneRingRows<float> loop_rows() {
  using namespace fused_rows;
  return HWY_DYNAMIC_DISPATCH(loop_float)();
}
template <>
fused_rows::OneRingRows<double> loop_rows() {
  using namespace fused_rows;
  return HWY_DYNAMIC_DISPATCH(loop_double)();
}
template <>
fused_rows::OneRingRows<float> midpoint_rows() {
  using namespace fused_rows;
  return HWY_DYNAMIC_DISPATCH(midpoint_float)();
}
template <>
fused_rows::OneRingRows<double> midpoint_rows() {
  using namespace fused_rows;
  return HWY_DYNAMIC_DISPATCH(midpoint_double)();
}
template <>
fused_rows::ButterflyRows<float> butterfly_rows() {
  using namespace fused_rows;
  return HWY_DYNAMIC_DISPATCH(butterfly_float)();
}
template <>
fused_rows::ButterflyRows<double> butterfly_rows() {
  using namespace fused_rows;
  return HWY_DYNAMIC_DISPATCH(butterfly_double)();
}

}  // namespace plait
#endif
