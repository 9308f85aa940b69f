#include "job.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <string>

#include "base/interruption.h"
#include "base/stopwatch.h"
#include "plait/error.h"
#include "plait/registry.h"
#include "process_figures.h"

PLAIT_BEGIN_PRIVATE_NAMESPACE
namespace {

Error refused(const std::string& message) { return {ErrorCode::kInvalidArgument, message}; }

const Job& job_named(std::string_view name) {
  const auto found =
      std::ranges::find(all_jobs(), name, [](const Job& job) { return job.about.name; });
  if (found != all_jobs().end()) return *found;
  std::vector<std::string> names;
  for (const Job& job : all_jobs()) names.push_back(job.about.name);
  throw refused(
      fmt::format("run a job: expected one of {}, found \"{}\"", fmt::join(names, ", "), name));
}

std::size_t place_of(const JobDescription& job, const std::string& name) {
  const auto found = std::ranges::find(job.options, name, &JobOption::name);
  if (found != job.options.end()) return static_cast<std::size_t>(found - job.options.begin());
  std::vector<std::string> names;
  for (const JobOption& option : job.options) names.push_back(option.name);
  throw refused(fmt::format("{}: expected one of the options {}, found \"{}\"", job.name,
                            fmt::join(names, ", "), name));
}

/// Sets the arguments of a job from texts.
void set_options(const Job& job, const JobOptions& options, const std::string& prefix,
                 void* arguments) {
  std::vector<bool> given(job.setters.size());
  for (const auto& [name, text] : options) {
    const std::size_t place = place_of(job.about, name);
    const JobOption& option = job.about.options[place];
    try {
      if (given[place] && option.kind != OptionKind::kTexts)
        throw refused("expected it once, found it twice");
      given[place] = true;
      check_option(option, text);
      job.setters[place](arguments, text);
    } catch (const Error& error) {
      throw JobError(error, fmt::format("{}: {}{}: {}", job.about.name, prefix, name, error.what()),
                     name);
    }
  }
  for (std::size_t place = 0; place < given.size(); ++place)
    if (const JobOption& option = job.about.options[place]; option.required && !given[place])
      throw JobError(ErrorCode::kInvalidArgument,
                     fmt::format("{}: expected the option {}{}, found none", job.about.name, prefix,
                                 option.name),
                     option.name);
}

/// Says which option avoids an error.
std::string advice(const JobDescription& job, const std::string& name, const std::string& prefix) {
  const auto option = std::ranges::find(job.options, name, &JobOption::name);
  if (option == job.options.end() || option->position >= 0) return {};
  if (option->remedy.empty()) return fmt::format(" ({}{})", prefix, name);
  return fmt::format("; {}{} {}", prefix, name, option->remedy);
}

nlohmann::ordered_json to_json(const JobDescription& job) {
  nlohmann::ordered_json json = {{"name", job.name}, {"summary", job.summary}};
  json["options"] = nlohmann::ordered_json::array();
  for (const JobOption& option : job.options)
    json["options"].push_back(
        {{"name", option.name},
         {"kind", to_string(option.kind)},
         {"help", option.help},
         {"default", option.default_text ? nlohmann::ordered_json(*option.default_text)
                                         : nlohmann::ordered_json(nullptr)},
         {"choices", option.choices},
         {"required", option.required},
         {"position", option.position}});
  return json;
}

}  // namespace

std::string_view to_string(OptionKind kind) noexcept {
  switch (kind) {
    case OptionKind::kPath:
      return "path";
    case OptionKind::kText:
      return "text";
    case OptionKind::kTexts:
      return "texts";
    case OptionKind::kBytes:
      return "bytes";
    case OptionKind::kCount:
      return "count";
    case OptionKind::kNumber:
      return "number";
    case OptionKind::kChoice:
      return "choice";
    case OptionKind::kFlag:
      return "flag";
  }
  return "unknown";
}

const std::vector<JobDescription>& known_jobs() {
  static const std::vector<JobDescription> described = [] {
    std::vector<JobDescription> made;
    for (const Job& job : all_jobs()) made.push_back(job.about);
    return made;
  }();
  return described;
}

const JobDescription& find_job(std::string_view name) { return job_named(name).about; }

std::string job_description_json(std::string_view name) {
  if (!name.empty()) return to_json(find_job(name)).dump();
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const JobDescription& job : known_jobs()) json.push_back(to_json(job));
  return json.dump();
}

void check_option(const JobOption& option, const std::string& text) {
  const auto is_choice = [&] {
    return std::ranges::find(option.choices, text) != option.choices.end();
  };
  switch (option.kind) {
    case OptionKind::kPath:
      if (text.empty() || (option.output && text == "-"))
        throw refused(fmt::format("expected a name{}, found \"{}\"",
                                  option.output ? " (nothing is written to standard output; ./- is "
                                                  "a file called -)"
                                                : "",
                                  text));
      return;
    case OptionKind::kBytes:
      parse_size(text);
      return;
    case OptionKind::kCount:
      if (!is_choice()) parse_whole_number(text, option.first, option.last);
      return;
    case OptionKind::kNumber:
      if (!is_choice()) parse_number(text, option.low, option.high);
      return;
    case OptionKind::kChoice:
      if (!is_choice())
        throw refused(
            fmt::format("expected one of {}, found \"{}\"", fmt::join(option.choices, ", "), text));
      return;
    case OptionKind::kFlag:
      if (text != "true" && text != "false")
        throw refused(fmt::format("expected true or false, found \"{}\"", text));
      return;
    case OptionKind::kText:
    case OptionKind::kTexts:
      return;
  }
}

std::string run_job(std::string_view name, const JobOptions& options, const JobWatch& watch,
                    const JobContext& context) {
  const Job& job = job_named(name);
  const Stopwatch clock;
  const double cpu_seconds_before = cpu_seconds();
  const std::shared_ptr<void> arguments = job.make();
  set_options(job, options, context.option_prefix, arguments.get());
  Interruptible interruptible(name, watch.progress);
  JobWatch asked = watch;
  asked.progress = interruptible.progress();
  try {
    const BackendRegistry& backends =
        context.backends != nullptr ? *context.backends : default_backends();
    JobReport report =
        job.run(arguments.get(),
                {backends, context.open_backends != nullptr ? *context.open_backends : backends,
                 asked, context.parallel_for, options});
    report["seconds"] = clock.seconds();
    report["cpu_seconds"] = cpu_seconds() - cpu_seconds_before;
    report["peak_rss_bytes"] = peak_rss_bytes();
    // A name in a file system may be no UTF-8.
    return report.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  } catch (const JobError& error) {
    throw JobError(error, error.what() + advice(job.about, error.option(), context.option_prefix),
                   error.option(), error.report());
  } catch (const std::bad_alloc&) {
    throw out_of_memory(name);
  }
}

PLAIT_END_NAMESPACE
