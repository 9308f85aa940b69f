// Jobs: their options are texts, and their reports are JSON.
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>

#include "guard.h"
#include "handles.h"
#include "plait.h"
#include "plait/job.h"
#include "plugins.h"

struct plait_text {
  std::string text;
};

namespace plait::c {
namespace {

JobOptions options_in(const char* const* options, std::uint64_t count) {
  if (count > 0) check_given(options, "options");
  JobOptions texts;
  for (std::uint64_t at = 0; at < count; ++at) {
    check_given(options[at], "options");
    const std::string text = options[at];
    const std::size_t sign = text.find('=');
    if (sign == std::string::npos)
      texts.emplace_back(text, "true");
    else
      texts.emplace_back(text.substr(0, sign), text.substr(sign + 1));
  }
  return texts;
}

}  // namespace
}  // namespace plait::c

using namespace plait::c;

const char* plait_text_string(const plait_text* text) {
  return text == nullptr ? "" : text->text.c_str();
}

void plait_text_release(plait_text* text) { delete text; }

plait_status plait_job_options(const char* job, plait_text** options) {
  return guarded("plait_job_options", [&] {
    check_given(options, "options");
    *options = new plait_text{plait::job_description_json(text_or(job, ""))};
  });
}

plait_status plait_job_run(const char* job, const char* const* options, uint64_t count,
                           plait_progress progress, plait_warning warning, void* user,
                           plait_text** report) {
  return guarded("plait_job_run", [&] {
    check_given(job, "job");
    plait::JobWatch watch;
    watch.progress = progress_by(progress, user);
    if (warning != nullptr)
      watch.warn = [=](const std::string& text) { warning(text.c_str(), user); };
    const plait::BackendRegistry backends = known_backends();  // outlives the job
    auto done = std::make_unique<plait_text>();
    done->text = plait::run_job(job, options_in(options, count), watch, {.backends = &backends});
    if (report != nullptr) *report = done.release();
  });
}
