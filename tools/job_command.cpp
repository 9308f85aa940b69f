#include "job_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <deque>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "arguments.h"
#include "console.h"
#include "interrupt.h"
#include "json_text.h"
#include "plait/job.h"
#include "progress.h"

namespace plait {
namespace {

/// What the command line has said of one option.
struct GivenOption {
  const JobOption* option;
  std::vector<std::string> texts;
  bool flag = false;
};

/// Draws a progress bar for each step, and lets a signal end the job.
class JobWatcher {
 public:
  JobWatcher(const std::string& job, bool json)
      : job_(job), progress_(std::in_place, job, ProgressUnit::kNone), nothing_is_made_yet_(json) {}

  /// REQUIRES: this object outlives the run of the job.
  JobWatch watch() {
    return {[this](std::string_view step) { enter(step); },
            [this](const Progress& now) {
              const std::string_view phase = now.phase == step_ ? std::string_view() : now.phase;
              return progress_->update(now.done, now.total, phase);
            },
            [this](const std::string& warning) {
              progress_->clear();
              report_warning(warning);
            },
            [this] { nothing_is_made_yet_.end(); }};
  }

 private:
  void enter(std::string_view step) {
    step_ = step;
    progress_.emplace(step_ == job_ ? job_ : job_ + ": " + step_,
                      step_ == "levels"                         ? ProgressUnit::kVertices
                      : step_ == "convert" || step_ == "encode" ? ProgressUnit::kBytes
                                                                : ProgressUnit::kNone);
  }

  std::string job_, step_;
  std::optional<ProgressBar> progress_;
  EndAtOnce nothing_is_made_yet_;
};

JobOptions texts_of(const std::deque<GivenOption>& given, const JobOptions& unless_given) {
  JobOptions options;
  for (const auto& each : unless_given)
    if (std::ranges::none_of(given, [&](const GivenOption& option) {
          return option.option->name == each.first && !option.texts.empty();
        }))
      options.push_back(each);
  for (const GivenOption& each : given) {
    if (each.flag) options.emplace_back(each.option->name, "true");
    for (const std::string& text : each.texts) options.emplace_back(each.option->name, text);
  }
  return options;
}

void add_job_option(CommandLine& command, const JobOption& option, GivenOption& given) {
  std::string name = "--" + option.name;
  if (option.position >= 0) {
    name = option.name;
    std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::toupper(c); });
  }
  if (option.kind == OptionKind::kFlag) {
    command.add_flag(name, given.flag, option.help);
    return;
  }
  const auto take = [&given](const std::string& text) {
    check_option(*given.option, text);
    given.texts.assign(1, text);
  };
  Option* added = nullptr;
  if (option.kind == OptionKind::kTexts)
    added = command.add_option(name, given.texts, option.help)->allow_extra_args(false);
  else if (option.kind == OptionKind::kNumber && !option.choices.empty())
    added = command.add_option_with_optional_number(name, take, option.help);
  else
    added = command.add_parsed_option(name, take, option.help);
  // As the command line itself writes the values of an option: the completion reads them.
  added->type_name(option.kind == OptionKind::kChoice
                       ? fmt::format("{{{}}}", fmt::join(option.choices, ","))
                       : option.value_name);
  if (option.required) added->required();
  if (option.default_text) added->default_str(*option.default_text);
}

int run_job_command(const JobCommand& command, const std::deque<GivenOption>& given,
                    const CommandContext& context) {
  const JobOptions options = texts_of(given, command.unless_given);
  nlohmann::ordered_json report;
  try {
    report = run_with_progress(command.job, options, context);
  } catch (const Error& error) {
    if (const auto* of_job = dynamic_cast<const JobError*>(&error);
        of_job != nullptr && !of_job->report().empty() && command.failed)
      return command.failed(nlohmann::ordered_json::parse(of_job->report()), context.json);
    const auto plan =
        std::ranges::find(options, command.plan_option, &JobOptions::value_type::first);
    if (command.plan_option.empty() || plan == options.end()) throw;
    report_error(to_string(error.code()), error.what(), context.json);
    return exit_status_with_plan(error, plan->second);
  }
  print(context.json ? json_text(report) : command.text(report));
  return kExitDone;
}

}  // namespace

nlohmann::ordered_json run_with_progress(const std::string& job, const JobOptions& options,
                                         const CommandContext& context) {
  JobWatcher watcher(job, context.json);
  return nlohmann::ordered_json::parse(run_job(job, options, watcher.watch(),
                                               {.backends = &context.backends,
                                                .open_backends = &context.open_backends,
                                                .option_prefix = "--"}));
}

void add_job_command(CommandLine& program, CommandContext& context, JobCommand command) {
  // The callback keeps the description: options refer to it.
  const auto shared = std::make_shared<const JobCommand>(std::move(command));
  const JobDescription& job = shared->described ? *shared->described : find_job(shared->job);
  CommandLine* const line = program.add_subcommand(job.name, job.summary);
  const auto given = std::make_shared<std::deque<GivenOption>>();
  for (const JobOption& option : job.options) {
    given->push_back({&option, {}});
    add_job_option(*line, option, given->back());
  }
  add_plugin_option(*line, context);
  add_json_option(*line, context);
  line->footer(shared->footer);
  line->callback([given, &context, shared] {
    context.run = [given, &context, shared] { return run_job_command(*shared, *given, context); };
  });
}

}  // namespace plait
