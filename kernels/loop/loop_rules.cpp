#include "plait/kernels/loop_rules.h"

#include "loop/loop_expressions.h"

namespace plait::loop {

template <class Real>
Vector3<Real> odd_vertex(const Vector3<Real>& a, const Vector3<Real>& b, const Vector3<Real>& c,
                         const Vector3<Real>& d) noexcept {
  return by_axis<Real>(odd<Real>, a, b, c, d);
}

template <class Real>
Vector3<Real> odd_border_vertex(const Vector3<Real>& a, const Vector3<Real>& b) noexcept {
  return Real(0.5) * (a + b);
}

template <class Real>
Vector3<Real> even_vertex(const Vector3<Real>& v, const Vector3<Real>& p0, const Vector3<Real>& p1,
                          const Vector3<Real>& p2, const Vector3<Real>& p3, const Vector3<Real>& p4,
                          const Vector3<Real>& p5) noexcept {
  return by_axis<Real>(even<Real>, v, p0 + p3, p1 + p4, p2 + p5);
}

template <class Real>
Vector3<Real> even_border_vertex(const Vector3<Real>& v, const Vector3<Real>& p,
                                 const Vector3<Real>& q) noexcept {
  return by_axis<Real>(even_border<Real>, v, p, q);
}

template <class Real>
Vector3<Real> limit_vertex(const Vector3<Real>& v, const Vector3<Real>& p0, const Vector3<Real>& p1,
                           const Vector3<Real>& p2, const Vector3<Real>& p3,
                           const Vector3<Real>& p4, const Vector3<Real>& p5) noexcept {
  return by_axis<Real>(limit<Real>, v, p0 + p3, p1 + p4, p2 + p5);
}

template <class Real>
Vector3<Real> limit_border_vertex(const Vector3<Real>& v, const Vector3<Real>& p,
                                  const Vector3<Real>& q) noexcept {
  return by_axis<Real>(limit_border<Real>, v, p, q);
}

template Vector3<float> odd_vertex(const Vector3<float>&, const Vector3<float>&,
                                   const Vector3<float>&, const Vector3<float>&) noexcept;
template Vector3<float> odd_border_vertex(const Vector3<float>&, const Vector3<float>&) noexcept;
template Vector3<float> even_vertex(const Vector3<float>&, const Vector3<float>&,
                                    const Vector3<float>&, const Vector3<float>&,
                                    const Vector3<float>&, const Vector3<float>&,
                                    const Vector3<float>&) noexcept;
template Vector3<float> even_border_vertex(const Vector3<float>&, const Vector3<float>&,
                                           const Vector3<float>&) noexcept;
template Vector3<float> limit_vertex(const Vector3<float>&, const Vector3<float>&,
                                     const Vector3<float>&, const Vector3<float>&,
                                     const Vector3<float>&, const Vector3<float>&,
                                     const Vector3<float>&) noexcept;
template Vector3<float> limit_border_vertex(const Vector3<float>&, const Vector3<float>&,
                                            const Vector3<float>&) noexcept;
template Vector3<double> odd_vertex(const Vector3<double>&, const Vector3<double>&,
                                    const Vector3<double>&, const Vector3<double>&) noexcept;
template Vector3<double> odd_border_vertex(const Vector3<double>&, const Vector3<double>&) noexcept;
template Vector3<double> even_vertex(const Vector3<double>&, const Vector3<double>&,
                                     const Vector3<double>&, const Vector3<double>&,
                                     const Vector3<double>&, const Vector3<double>&,
                                     const Vector3<double>&) noexcept;
template Vector3<double> even_border_vertex(const Vector3<double>&, const Vector3<double>&,
                                            const Vector3<double>&) noexcept;
template Vector3<double> limit_vertex(const Vector3<double>&, const Vector3<double>&,
                                      const Vector3<double>&, const Vector3<double>&,
                                      const Vector3<double>&, const Vector3<double>&,
                                      const Vector3<double>&) noexcept;
template Vector3<double> limit_border_vertex(const Vector3<double>&, const Vector3<double>&,
                                             const Vector3<double>&) noexcept;

}  // namespace plait::loop
