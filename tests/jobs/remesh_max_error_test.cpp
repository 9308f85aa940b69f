// remesh --max-error: every coordinate stays within the bound, and the store is what convert would
// leave as it is. What the store notes of its scan.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "conversion/conversion_job.h"
#include "format/packed_mesh.h"
#include "plait/compression.h"
#include "plait/digest.h"
#include "plait/error.h"
#include "plait/extend/store_access.h"
#include "plait/notes.h"
#include "remesh_files.h"
#include "support/error_of.h"

namespace plait::test {
namespace {

template <class Real>
std::vector<double> coordinates_of(Store store) {
  std::vector<double> all;
  for_each_patch(store, [&](const PatchView& patch) {
    const auto position = patch.attribute<Vector3<Real>>("position");
    for (std::int64_t j = 0; j <= patch.size(); ++j)
      for (std::int64_t i = 0; i + j <= patch.size(); ++i) {
        const Vector3<Real>& p = position.at(i, j);
        all.insert(all.end(), {double{p.x}, double{p.y}, double{p.z}});
      }
  });
  return all;
}

}  // namespace

TEMPLATE_TEST_CASE("Remesh_MaxError_MovesNoCoordinateFartherAndConvertChangesNothing", "", float,
                   double) {
  const RemeshFiles files;
  write_ply(files.scan, random_sphere(3, 800));
  RemeshRequest request = files.request(60);
  request.precision = sizeof(TestType) == 4 ? ComponentType::kFloat32 : ComponentType::kFloat64;
  files.run(request);
  const std::vector<double> exact = coordinates_of<TestType>(files.open());
  for (const char* const text : {"1e-3", "1e-5rel", "3e-4,euclidean"}) {
    CAPTURE(text);
    request.max_error = ErrorBound::parse(text);
    request.options.backend = "compressed";
    request.options.pipeline_of = [](const AttributeSchema& schema) {
      return Compression().pipeline_of(schema);
    };
    request.digest = true;
    const RemeshReport report = files.run(request);
    REQUIRE(report.rounding);
    const Store store = files.open();
    const AttributeId position = store.attribute("position");
    CHECK(StoreAccess::rounding(store, position) == report.rounding);
    const std::vector<double> rounded = coordinates_of<TestType>(files.open());
    REQUIRE(rounded.size() == exact.size());
    double largest = 0;
    for (std::size_t at = 0; at < exact.size(); ++at)
      largest = std::max(largest, std::abs(rounded[at] - exact[at]));
    CHECK(largest <= report.rounding->bound);
    CHECK(largest > report.rounding->bound / 4);

    const PositionWords words = words_of(store.base().positions());
    CHECK(words.form == PositionForm::kWhole);
    CHECK(std::ldexp(1.0, words.exponent) > report.rounding->step / 4);
    const auto base = store.base_records<Vector3<TestType>>(position);
    for (std::size_t v = 0; v < base.size(); ++v) {
      CHECK(double{base[v].x} == store.base().positions()[v].x);
      CHECK(double{base[v].y} == store.base().positions()[v].y);
      CHECK(double{base[v].z} == store.base().positions()[v].z);
    }
    CHECK_FALSE(store.base().differs_from_input());

    ConversionRequest conversion{.from = files.store,
                                 .to = files.directory.path() / "converted.plait"};
    conversion.max_errors.add(text);
    conversion.existing = Existing::kReplace;
    const ConversionResult converted = convert(conversion, default_backends(), default_backends());
    CHECK(converted.roundings.at("position").largest_error == report.rounding->largest_error);
    Store copy = Store::open(conversion.to, {}, default_backends());
    CHECK(digest(copy).to_string() == report.digest);
  }
}

TEST_CASE("Remesh_NotesHowFarItsScanIs") {
  const RemeshFiles files;
  write_ply(files.scan, random_sphere(3, 800));
  RemeshRequest request = files.request(60);
  const RemeshReport report = files.run(request);
  {
    const Store store = files.open();
    const std::string& noted = store.notes().texts().at("remesh-rms");
    CHECK(std::stod(noted) ==
          Approx(std::max(report.to_store.rms, report.to_scan.rms)).epsilon(1e-8));
  }
  request.report_samples = 0;
  files.run(request);
  CHECK(files.open().notes().texts().empty());
}

}  // namespace plait::test
