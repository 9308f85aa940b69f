#include "micro/support.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "instrument/page.h"
#include "instrument/statistics.h"

namespace plait::bench {
namespace {

std::string text_of(const Figure& figure, const std::vector<double>& values) {
  if (values.empty()) return "-";
  std::string text = fmt::format("{:.{}f}", instrument::median(values), figure.digits);
  if (!figure.spread) return text;
  const auto [least, most] = std::ranges::minmax(values);
  return fmt::format("{} ({:.{}f} to {:.{}f})", text, least, figure.digits, most, figure.digits);
}

}  // namespace

Measurements::Measurements(std::string labels, std::vector<Figure> figures)
    : labels_(std::move(labels)), figures_(std::move(figures)) {}

void Measurements::add(const std::vector<std::string>& labels,
                       std::initializer_list<double> values) {
  auto row = std::ranges::find(rows_, labels, &Row::labels);
  if (row == rows_.end())
    row = rows_.insert(row, {labels, std::vector<std::vector<double>>(figures_.size())});
  for (std::size_t at = 0; const double value : values)
    if (std::vector<double>& of_figure = row->values.at(at++); std::isfinite(value))
      of_figure.push_back(value);
}

void Measurements::print(const std::string& about) const {
  std::string columns = labels_;
  for (const Figure& figure : figures_) columns += "|#" + figure.name;
  instrument::Table table = instrument::table_with(columns);
  for (const Row& row : rows_) {
    std::vector<std::string>& cells =
        table.rows.emplace_back(instrument::Table::Row{row.labels}).cells;
    for (std::size_t at = 0; at < figures_.size(); ++at)
      cells.push_back(text_of(figures_[at], row.values[at]));
  }
  std::fputs((about + "\n\n" + to_markdown(table)).c_str(), stdout);
}

}  // namespace plait::bench
