#include "instrument/html_page.h"

#include <fmt/format.h>

#include <cmath>

#include "instrument/page_assets.h"

namespace plait::instrument {
namespace {

using nlohmann::ordered_json;

/// The same text with replacement characters for what is not UTF-8, and without control characters.
std::string valid_text(std::string_view text) {
  const ordered_json quoted(std::string{text});
  std::string valid =
      ordered_json::parse(quoted.dump(-1, ' ', false, ordered_json::error_handler_t::replace));
  for (char& character : valid)
    if (static_cast<unsigned char>(character) < 0x20 && character != '\n') character = ' ';
  return valid;
}

std::string_view class_of(Tone tone) {
  switch (tone) {
    case Tone::kGood:
      return "good";
    case Tone::kDoubt:
      return "doubt";
    case Tone::kFailed:
      return "failed";
    case Tone::kPlain:
      break;
  }
  return "plain";
}

std::string_view name_of(Scale scale) {
  switch (scale) {
    case Scale::kLog:
      return "log";
    case Scale::kLinear:
      break;
  }
  return "linear";
}

ordered_json json_of(const Axis& axis) {
  return {{"label", axis.label},
          {"unit", axis.unit},
          {"scale", name_of(axis.scale)},
          {"zero", axis.from_zero}};
}

/// JSON has no word for what is not finite.
ordered_json json_of(double value) { return std::isfinite(value) ? ordered_json(value) : nullptr; }

/// A cell of the tables under the plots, with the exact number.
Cell number_cell(double value) {
  if (!std::isfinite(value)) return Cell("–", kMissing);
  return Cell(fmt::format("{:.6g}", value), value);
}

}  // namespace

std::string escape_html(std::string_view text) {
  std::string escaped;
  for (const char character : valid_text(text)) switch (character) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += character;
    }
  return escaped;
}

std::string script_json(const ordered_json& data) {
  std::string escaped;
  // With '<' as \u003c there is neither "</script" nor "<!--"; both only occur inside strings.
  for (const char character : data.dump(-1, ' ', false, ordered_json::error_handler_t::replace))
    switch (character) {
      case '<':
        escaped += "\\u003c";
        break;
      case '>':
        escaped += "\\u003e";
        break;
      case '&':
        escaped += "\\u0026";
        break;
      default:
        escaped += character;
    }
  return escaped;
}

HtmlPage::HtmlPage(std::string title, std::string subtitle)
    : title_(std::move(title)), subtitle_(std::move(subtitle)) {}

void HtmlPage::verdict(const std::string& sentence, Tone tone) {
  failed_ = failed_ || tone == Tone::kFailed;
  body_ += fmt::format("<p class=\"verdict {}\">{}</p>\n", class_of(tone), escape_html(sentence));
}

void HtmlPage::section(const std::string& heading) {
  body_ += fmt::format("<h2>{}</h2>\n", escape_html(heading));
}

void HtmlPage::paragraph(const std::string& text) {
  body_ += fmt::format("<p>{}</p>\n", escape_html(text));
}

void HtmlPage::list(const std::vector<std::string>& items, Tone tone) {
  body_ += fmt::format("<ul class=\"{}\">\n", class_of(tone));
  for (const std::string& item : items) body_ += fmt::format("<li>{}</li>\n", escape_html(item));
  body_ += "</ul>\n";
}

void HtmlPage::command(const std::string& text) {
  body_ += fmt::format("<pre>{}</pre>\n", escape_html(text));
}

void HtmlPage::begin_figure(const Caption& caption) {
  body_ += fmt::format("<figcaption><strong>{}</strong>", escape_html(caption.title));
  if (!caption.how_to_read.empty())
    body_ += fmt::format("<p>{}</p>", escape_html(caption.how_to_read));
  body_ += "</figcaption>\n";
}

void HtmlPage::write_rows(const Table& table) {
  body_ += "<div class=\"scroll\" tabindex=\"0\"><table class=\"sortable\">\n<thead><tr>";
  for (const Table::Column& column : table.columns)
    body_ += fmt::format("<th scope=\"col\"{}>{}</th>", column.number ? " class=\"number\"" : "",
                         escape_html(column.name));
  body_ += "</tr></thead>\n<tbody>\n";
  for (const Table::Row& row : table.rows) {
    body_ +=
        row.tone == Tone::kPlain ? "<tr>" : fmt::format("<tr class=\"{}\">", class_of(row.tone));
    for (std::size_t at = 0; at < row.cells.size() && at < table.columns.size(); ++at) {
      const Cell& cell = row.cells[at];
      body_ += table.columns[at].number ? "<td class=\"number\"" : "<td";
      // The shortest text that reads back as the same number.
      if (cell.value && std::isfinite(*cell.value))
        body_ += fmt::format(" data-value=\"{}\"", *cell.value);
      body_ += '>';
      body_ += escape_html(cell.text);
      body_ += "</td>";
    }
    body_ += "</tr>\n";
  }
  body_ += "</tbody>\n</table></div>\n";
}

void HtmlPage::table(const Table& table) {
  body_ += "<figure>\n";
  if (!table.caption.title.empty()) begin_figure(table.caption);
  write_rows(table);
  if (!table.caption.command.empty()) command(table.caption.command);
  body_ += "</figure>\n";
}

void HtmlPage::add_plot(const Caption& caption, ordered_json plot, const Table& numbers) {
  if (numbers.rows.empty()) {
    paragraph(caption.title + ": no run measured this.");
    return;
  }
  if (numbers.rows.size() < kLeastPoints && plot["kind"] != "scatter") {
    Table shown = numbers;
    shown.caption = caption;
    return table(shown);
  }
  body_ += fmt::format("<figure id=\"plot-{}\">\n", plots_.size());
  begin_figure(caption);
  body_ += "<div class=\"plot\"></div>\n<details><summary>The numbers</summary>\n";
  write_rows(numbers);
  body_ += "</details>\n";
  if (!caption.command.empty()) command(caption.command);
  body_ += "</figure>\n";
  plot["title"] = caption.title;
  plots_.push_back(std::move(plot));
}

void HtmlPage::plot(const IntervalPlot& plot) {
  Table numbers{{},
                {{"group", false},
                 {"name", false},
                 {"series", false},
                 {plot.x.label},
                 {"low"},
                 {"high"},
                 {"note", false}}};
  ordered_json points = ordered_json::array();
  for (const IntervalPlot::Point& point : plot.points) {
    points.push_back({{"group", point.group},
                      {"name", point.name},
                      {"series", point.series},
                      {"value", json_of(point.value)},
                      {"low", json_of(point.low)},
                      {"high", json_of(point.high)},
                      {"note", point.note},
                      {"hollow", point.hollow}});
    numbers.rows.push_back({{point.group, point.name, point.series, number_cell(point.value),
                             number_cell(point.low), number_cell(point.high), point.note}});
  }
  add_plot(plot.caption,
           {{"kind", "intervals"},
            {"x", json_of(plot.x)},
            {"reference", plot.reference ? json_of(*plot.reference) : ordered_json(nullptr)},
            {"points", std::move(points)}},
           numbers);
}

void HtmlPage::plot(const ScatterPlot& plot) {
  Table numbers{{},
                {{"series", false},
                 {"name", false},
                 {plot.x.label},
                 {plot.y.label},
                 {"on the front", false},
                 {"note", false}}};
  ordered_json points = ordered_json::array();
  for (const ScatterPlot::Point& point : plot.points) {
    points.push_back({{"series", point.series},
                      {"name", point.name},
                      {"x", json_of(point.x)},
                      {"y", json_of(point.y)},
                      {"x_low", json_of(point.x_low)},
                      {"x_high", json_of(point.x_high)},
                      {"y_low", json_of(point.y_low)},
                      {"y_high", json_of(point.y_high)},
                      {"front", point.front},
                      {"note", point.note}});
    numbers.rows.push_back({{point.series, point.name, number_cell(point.x), number_cell(point.y),
                             point.front ? "yes" : "", point.note},
                            point.front ? Tone::kGood : Tone::kPlain});
  }
  add_plot(plot.caption,
           {{"kind", "scatter"},
            {"x", json_of(plot.x)},
            {"y", json_of(plot.y)},
            {"points", std::move(points)}},
           numbers);
}

void HtmlPage::embed(const std::string& id, const ordered_json& data) {
  data_ += fmt::format("<script type=\"application/json\" id=\"{}\">{}</script>\n", escape_html(id),
                       script_json(data));
}

std::string HtmlPage::html() const {
  std::string page = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
      "'unsafe-inline'; script-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action "
      "'none'\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<link rel=\"icon\" href=\"data:,\">\n<title>{}{}</title>\n<style>\n",
      failed_ ? "FAILED: " : "", escape_html(title_));
  page += kPageStyle;
  page +=
      fmt::format("</style>\n</head>\n<body{}>\n<h1>{}</h1>\n<p class=\"subtitle\">{}</p>\n",
                  failed_ ? " class=\"failed\"" : "", escape_html(title_), escape_html(subtitle_));
  page +=
      "<noscript><p class=\"verdict doubt\">Plots are drawn by a script, which this browser does "
      "not "
      "run. The numbers of each plot are in the table under it.</p></noscript>\n";
  page += body_;
  page += data_;
  page += fmt::format(
      "<script type=\"application/json\" id=\"plots\">{}</script>\n<script>\"use strict\";",
      script_json(plots_));
  page += kPageScript;
  page += "</script>\n</body>\n</html>\n";
  return page;
}

}  // namespace plait::instrument
