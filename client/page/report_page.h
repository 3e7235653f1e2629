/// Motions and the answers to them as a page that shows them.
#pragma once

#include "study/measured.h"
#include "study/outcome.h"

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace torqued
{

/// When a sample was answered.
struct AnswerTime
{
  double compute_us; ///< what the daemon needed for it, µs
  double delay_us;   ///< from its desired state to the answer as the logger heard them, µs
};

/// What answered a motion: a daemon that was recorded, or a method.
struct ReportRun
{
  std::string name;
  Answers answers;                                ///< by sample
  std::vector<AnswerTime> times;                  ///< by sample, NaN where there is none; empty if nothing was recorded
  std::map<std::string, std::int64_t> unanswered; ///< samples by the reason's name
};

/// A motion, and all that is known about it.
struct ReportMotion
{
  std::string source; ///< the file's name, for people
  double start = 0.0; ///< time of the first sample, s
  std::vector<DesiredState> states;
  std::vector<ReportRun> runs;
  Measured measured;
};

/// The most samples of a motion that a page holds one by one. Of a longer one it holds this many poses, and curves as
/// the least and the largest value of each of so many stretches, so that no peak is lost; figures are always those of
/// all samples.
struct Resolution
{
  std::size_t frames = 36'000;
  std::size_t stretches = 20'000;
};

/// How fresh a live motion is.
struct Liveness
{
  std::optional<double> answer_age; ///< s since the last answer; nothing if none was heard
  double status_age;                ///< s since torqued's last status or, if none was heard, since listening began
  bool stopping = false;            ///< that status said that torqued was about to end
};

/// What the page shows, as JSON; script/document.js says how it is read.
///
/// Numbers of a column are 32-bit floats (times: 64-bit), little-endian, in base64; NaN where there is none.
std::string report_document(const Robot& robot, const std::vector<ReportMotion>& motions,
                            const Resolution& resolution = {}, const std::optional<Liveness>& liveness = {});

/// The document of a page that asks for others, again and again: of the robot, without a motion.
std::string live_document(const Robot& robot);

/// A page that needs nothing else: document, style, script and the plotting library in one HTML text.
std::string report_page(const std::string& title, const std::string& document);

} // namespace torqued
