#include "client/bus.h"
#include "client/live_motion.h"
#include "client/page_server.h"
#include "client/robot_choice.h"
#include "client/subcommands.h"
#include "robot/printable.h"

#include <CLI/CLI.hpp>

#include <fmt/format.h>
#include <memory>
#include <mutex>

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

// What the bus says and the browser asks for, each in a thread of its own.
class View
{
public:
  View(const model_info_t& model, const ViewOptions& options) : options_(options) { set_model(model); }

  void set_model(const model_info_t& model)
  {
    Robot robot = choose_drawn_robot(said_robot(options_.robot), robot_named_by(model));
    const std::lock_guard lock(mutex_);
    motion_ = std::make_unique<LiveMotion>(std::move(robot), options_.seconds);
    model_id_ = model.model_id;
  }
  // of the thread that hears the bus
  std::int64_t model_id() const { return model_id_; }

  template <typename Message> void hear(Bytes bytes)
  {
    Message message;
    if (!decode(bytes, message))
      return;
    const auto now = LiveMotion::Clock::now();
    const std::lock_guard lock(mutex_);
    if constexpr (std::is_same_v<Message, rejection_t>)
      motion_->hear(message);
    else
      motion_->hear(message, now);
  }

  std::string page() const
  {
    const std::lock_guard lock(mutex_);
    return report_page(fmt::format("live – {}", motion_->robot().name),
                       fmt::format(R"({{"live":true,"motions":[],"robot":{}}})", robot_document(motion_->robot())));
  }
  std::string document() const
  {
    // a screen's worth of each curve
    constexpr Resolution resolution{.frames = 1500, .stretches = 750};
    const std::lock_guard lock(mutex_);
    return report_document(motion_->robot(), motion_->window(LiveMotion::Clock::now()), resolution);
  }

private:
  const ViewOptions& options_;
  std::int64_t model_id_ = 0;
  mutable std::mutex mutex_;
  std::unique_ptr<LiveMotion> motion_;
};

ExitCode view(const ViewOptions& options)
{
  Config config;
  set_flag("--prefix", set_prefix, config, options.prefix);
  const Channels channels(config.prefix);
  Bus bus(options.lcm_url);
  if (!bus.wait_for_model(channels))
    return ExitCode::done;
  flush_denormals();
  View view(bus.model(), options);
  bus.subscribe(channels.desired, [&view](Bytes bytes) { view.hear<desired_state_t>(bytes); });
  bus.subscribe(channels.command, [&view](Bytes bytes) { view.hear<torque_command_t>(bytes); });
  bus.subscribe(channels.rejected, [&view](Bytes bytes) { view.hear<rejection_t>(bytes); });
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
  fmt::print("http://127.0.0.1:{}/ shows what {} does; Ctrl-C ends this\n", server.port(), printable(bus.model().name));
  std::fflush(stdout);
  while (!bus.stopped())
  {
    bus.wait(Bus::Clock::now() + std::chrono::milliseconds(200));
    if (bus.model().model_id != view.model_id())
      view.set_model(bus.model());
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
  app->footer("The page is served to this machine alone.\n\n"
              "Example, while torqued runs on this bus:\n"
              "  export LCM_DEFAULT_URL='udpm://239.255.76.67:7667?ttl=0'\n"
              "  torquectl view &\n"
              "  torquectl send --loop client/trajectories/subject01-walk/walk.csv");
  return {app, [options]
          {
            return view(*options);
          }};
}

} // namespace torqued
