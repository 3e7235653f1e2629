#include "bus/bus.h"
#include "commands/options.h"
#include "commands/robot_choice.h"
#include "commands/subcommands.h"
#include "motion/console.h"
#include "motion/old_messages.h"
#include "page/live_motion.h"
#include "page/page_server.h"
#include "text/printable.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <fmt/format.h>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>

namespace torqued
{

namespace
{

struct ViewOptions
{
  std::string robot, lcm_url;
  std::optional<std::string> prefix;
  int port = 8765;
  double seconds = 10.0;
};

// Whether two messages name the same robot, even if somebody made up one of them.
bool same_robot(const model_info_t& a, const model_info_t& b)
{
  const auto facts = [](const model_info_t& model)
  {
    return std::tie(model.model_id, model.name, model.num_coordinates, model.num_joints, model.num_links);
  };
  return facts(a) == facts(b);
}

// What the bus says and the browser asks for, each in a thread of its own.
class View
{
public:
  using Clock = LiveMotion::Clock;

  /// Throws Failure, FileError: the robot cannot be drawn, or is not the one that --robot says.
  View(const model_info_t& model, const ViewOptions& options) : options_(options) { set_model(model); }

  /// Likewise; what is shown then stays.
  void set_model(const model_info_t& model)
  {
    Robot robot = choose_drawn_robot(said_robot(options_.robot), robot_named_by(model));
    const std::lock_guard lock(mutex_);
    motion_ = std::make_unique<LiveMotion>(std::move(robot), options_.seconds);
    model_ = model;
    last_status_ = Clock::now();
    stopping_ = false;
  }
  // of the thread that hears the bus
  const model_info_t& model() const { return model_; }

  template <typename Message> void hear(Bytes bytes)
  {
    Message message;
    if (!decode(bytes, message))
      return;
    const auto now = Clock::now();
    const std::lock_guard lock(mutex_);
    if constexpr (std::is_same_v<Message, rejection_t>)
      motion_->hear(message);
    else
      motion_->hear(message, now);
  }
  void hear_status(Bytes bytes)
  {
    status_t status;
    if ((!decode(bytes, status) && !decode_old(bytes, status)) || status.model_id != model_.model_id)
      return;
    const std::lock_guard lock(mutex_);
    last_status_ = Clock::now();
    stopping_ = status.state == status_t::STOPPING;
  }

  std::string page() const
  {
    const std::lock_guard lock(mutex_);
    return report_page(fmt::format("live – {}", motion_->robot().name), live_document(motion_->robot()));
  }
  std::string document() const
  {
    // a screen's worth of each curve
    constexpr Resolution resolution{.frames = 1500, .stretches = 750};
    const auto now = Clock::now();
    const std::lock_guard lock(mutex_);
    const Liveness liveness{.answer_age = motion_->answer_age(now),
                            .status_age = std::chrono::duration<double>(now - last_status_).count(),
                            .stopping = stopping_};
    return report_document(motion_->robot(), motion_->window(now), resolution, liveness);
  }

private:
  const ViewOptions& options_;
  model_info_t model_;
  mutable std::mutex mutex_;
  std::unique_ptr<LiveMotion> motion_;
  Clock::time_point last_status_;
  bool stopping_ = false;
};

// Of a robot that cannot be shown the user is told once. told: the model_ids of those before.
void tell(std::set<std::int64_t>& told, const model_info_t& model, const std::exception& why)
{
  constexpr std::size_t most = 20; // who makes up more must not fill the terminal
  if (told.size() < most && told.insert(model.model_id).second)
    note(fmt::format("{} (model_id {}) is named on this bus, and not shown: {}", printable(model.name), model.model_id,
                     why.what()));
}

// Shows the first robot that can be shown, which need not be the first that somebody names. Nothing if a signal came.
std::unique_ptr<View> first_view(Bus& bus, const ViewOptions& options, std::set<std::int64_t>& told)
{
  const auto until = Bus::Clock::now() + Bus::kModelPatience;
  for (;;)
  {
    const model_info_t model = bus.model();
    try
    {
      return std::make_unique<View>(model, options);
    }
    catch (const Failure& failure)
    {
      if (!options.robot.empty())
        throw;
      tell(told, model, failure);
      while (same_robot(bus.model(), model) && !bus.stopped() && Bus::Clock::now() < until)
        bus.wait(until);
      if (bus.stopped())
        return nullptr;
      if (same_robot(bus.model(), model))
        throw;
    }
  }
}

ExitCode view(const ViewOptions& options)
{
  const Channels channels = channels_with(options.prefix);
  Bus bus(options.lcm_url);
  if (!bus.wait_for_model(channels))
    return ExitCode::done;
  flush_denormals();
  std::set<std::int64_t> told;
  const std::unique_ptr<View> first = first_view(bus, options, told);
  if (!first)
    return ExitCode::done;
  View& view = *first;
  bus.subscribe(channels.desired, [&view](Bytes bytes) { view.hear<desired_state_t>(bytes); });
  bus.subscribe(channels.command, [&view](Bytes bytes) { view.hear<torque_command_t>(bytes); });
  bus.subscribe(channels.rejected, [&view](Bytes bytes) { view.hear<rejection_t>(bytes); });
  bus.subscribe(channels.status, [&view](Bytes bytes) { view.hear_status(bytes); });
  const PageServer server({{"/", "text/html; charset=utf-8",
                            [&view]
                            {
                              return view.page();
                            }},
                           {"/document", "application/json",
                            [&view]
                            {
                              return view.document();
                            }}},
                          options.port);
  fmt::print("http://127.0.0.1:{}/ shows what {} does; Ctrl-C ends this\n", server.port(),
             printable(view.model().name));
  std::fflush(stdout);
  model_info_t named = view.model(); // last
  while (!bus.stopped())
  {
    bus.wait(Bus::Clock::now() + std::chrono::milliseconds(200));
    if (same_robot(bus.model(), named))
      continue;
    named = bus.model();
    try
    {
      if (!same_robot(named, view.model()))
        view.set_model(named);
    }
    catch (const std::runtime_error& error)
    {
      tell(told, named, error);
    }
  }
  return ExitCode::done;
}

} // namespace

Subcommand add_view(CLI::App& torquectl)
{
  const auto options = std::make_shared<ViewOptions>();
  CLI::App* app =
      torquectl.add_subcommand("view", "the page of report, live: what torqued does right now, in a browser");
  app->add_option("--port", options->port, "of 127.0.0.1, where the page is; 0: any that is free")
      ->type_name("N")
      ->check(CLI::Range(0, 65535))
      ->capture_default_str();
  app->add_option("--seconds", options->seconds, "how much of the past is shown")
      ->type_name("S")
      ->check(CLI::Range(0.5, 120.0))
      ->capture_default_str();
  add_robot_option(*app, options->robot, "default: the one that torqued computes");
  add_prefix_option(*app, options->prefix);
  add_bus_option(*app, options->lcm_url);
  app->footer(
      "The page is served to this machine alone. In red it says when the last answer is older than a second, when\n"
      "torqued is silent or has ended, and when this program does not answer.\n\n"
      "Example, while torqued runs on this bus:\n"
      "  export LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0'\n"
      "  torquectl view &\n"
      "  torquectl send --loop client/trajectories/subject01-walk/walk.csv");
  return {app, options, view};
}

} // namespace torqued
