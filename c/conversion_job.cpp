// The job that copies a store.
#include "conversion/conversion_job.h"

#include <algorithm>
#include <cstring>
#include <memory>

#include "guard.h"
#include "handles.h"
#include "job_options.h"
#include "plait.h"
#include "plugins.h"
#include "sized.h"

namespace plait::c {
namespace {

ConversionRequest conversion_request_of(const plait_conversion_request& wanted) {
  check_given(wanted.from_path, "from_path");
  check_given(wanted.to_path, "to_path");
  check_choice("existing", wanted.existing, 2);
  check_choice("verify", wanted.verify, 2);
  check_reserved(wanted.reserved);
  ConversionRequest request;
  request.from = wanted.from_path;
  request.to = wanted.to_path;
  request.backend = text_or(wanted.backend, "");
  request.compression = compression_of(wanted.compress, wanted.compress_count);
  request.max_errors = bounds_of(wanted.max_errors, wanted.max_error_count);
  request.block_bytes = wanted.block_bytes;
  if (wanted.budget_bytes != 0) request.budget_bytes = wanted.budget_bytes;
  if (wanted.threads != 0) request.threads = wanted.threads;
  request.verify = wanted.verify != 0;
  request.replace = wanted.existing == PLAIT_EXISTING_REPLACE;
  return request;
}

/// A step names the phase of all that it tells.
ConversionWatch conversion_watch_by(const plait_conversion_request& wanted) {
  ConversionWatch watch;
  if (wanted.progress != nullptr) {
    const auto step = std::make_shared<ConversionStep>(ConversionStep::kCopy);
    watch.step = [step](ConversionStep next) { *step = next; };
    watch.progress = [step,
                      progress = progress_by(wanted.progress, wanted.user)](const Progress& now) {
      return progress({to_string(*step), now.done, now.total});
    };
  }
  watch.warn = warnings_by(wanted.warn, wanted.user);
  return watch;
}

plait_conversion_result conversion_result_of(const ConversionResult& done) {
  plait_conversion_result result = PLAIT_CONVERSION_RESULT_INIT;
  result.from_stored_bytes = done.from_stored_bytes;
  result.stored_bytes = done.stored_bytes;
  std::memcpy(result.digest, done.digest.c_str(),
              std::min(done.digest.size() + 1, sizeof(result.digest)));
  return result;
}

}  // namespace
}  // namespace plait::c

using namespace plait::c;

plait_status plait_job_convert(const plait_conversion_request* request,
                               plait_conversion_result* result) {
  return guarded("plait_job_convert", [&] {
    check_given(request, "request");
    const plait_conversion_request wanted =
        options_of(request, plait_conversion_request PLAIT_CONVERSION_REQUEST_INIT);
    if (result != nullptr) check_result(result, "result");
    const plait::BackendRegistry backends = known_backends();
    const plait::ConversionResult done = plait::convert(conversion_request_of(wanted), backends,
                                                        backends, conversion_watch_by(wanted));
    if (result != nullptr) fill(result, conversion_result_of(done));
  });
}
