#include "studies/runner.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "backends/registry.h"
#include "core/version.h"
#include "studies/ranking.h"

namespace powdercal {
namespace {

using Clock = std::chrono::steady_clock;

double Seconds(Clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

// In the ledger: so that it does not count as a replicate of the point.
int BesidesReplicate(int replicate) { return -1 - replicate; }

constexpr auto kTick = std::chrono::milliseconds(250);

}  // namespace

StudyRunner::StudyRunner(Study& study, Options options)
    : study_(study),
      options_(std::move(options)),
      objectives_(study.MakeObjectives()),
      planner_(study),
      fidelities_(study, planner_) {
  start_ = Clock::now();
  const Availability& availability = planner_.availability();
  if (!availability.available) {
    throw InputError(fmt::format("backend '{}' is not available: {}", study.backend.backend->name(),
                                 availability.why_not));
  }
  std::string reason = planner_.ExplainUnsupported();
  if (reason.empty()) reason = planner_.ExplainUnsupported(options_.evaluate_also);
  if (!reason.empty()) throw InputError(reason, {.location = {study.file}});
  if (fidelities_.several()) *study.optimizer->fidelities() = fidelities_.levels();
  optimizer_ = study.optimizer->Make(study.space, objectives_, study.seed);
  cost_ = planner_.EstimateCost(options_.evaluate_also);
  PlanOthers();
  directory_ = std::make_unique<RunDirectory>(options_.folder, study.Fingerprint(), study.ToYaml(),
                                              study.base_folder);
  ledger_ = std::make_unique<Ledger>(directory_->ledger(), Ledger::Mode::read_write);
  const std::string earlier_version = ledger_->GetMeta("backend_version").value_or("");
  if (!earlier_version.empty() && earlier_version != availability.version) {
    throw InputError(
        fmt::format("the study was begun with {} {}, which is now {}: its runs cannot be "
                    "mixed; choose another folder with --out",
                    study.backend.backend->name(), earlier_version, availability.version),
        {.location = {directory_->folder().string()}});
  }
  ledger_->SetMeta("powdercal_version", kVersion);
  ledger_->SetMeta("backend_version", availability.version);
  ledger_->SetMeta("approximations", study.approximations.ToString());
  earlier_ = ledger_->TotalTimes();
  Replay();
}

StudyRunner::~StudyRunner() = default;

StudyRunner::End StudyRunner::Run() {
  session_ = ledger_->StartSession();
  ledger_->SetMeta("state", "running");
  executor_ = std::make_unique<LocalExecutor>(study_.parallel());
  if (!study_.budget.deterministic) TellWhatIsReady();
  RunJobs([this] { AskAndSubmit(); });
  if (stop_reason_.empty()) stop_reason_ = "the optimizer has no more points";
  SaveTimes(true);
  ledger_->SetMeta("state", interrupted_ ? "interrupted" : "finished");
  ledger_->SetMeta("stop_reason", interrupted_ ? "interrupted" : stop_reason_);
  ended_ = !interrupted_;
  if (!interrupted_) ConfirmElsewhere();
  if (!interrupted_) EvaluateTransfer();
  return interrupted_ ? End::interrupted : End::finished;
}

// Until nothing is queued or in flight.
void StudyRunner::RunJobs(const std::function<void()>& submit) {
  for (;;) {
    if (options_.stop.stop_requested() && !interrupted_) {
      interrupted_ = true;
      queue_.clear();
      executor_->Cancel();
    }
    if (!interrupted_) submit();
    if (in_flight_.empty() && (interrupted_ || queue_.empty())) break;
    const auto before = Clock::now();
    const auto finished = executor_->Wait(kTick);
    waiting_seconds_ += Seconds(Clock::now() - before);
    if (finished) Collect(*finished);
    if (options_.listener != nullptr) options_.listener->OnTick(CurrentProgress());
  }
}

// Plans runs of the best point that the calibration never hears of: they are in the ledger like all
// others, but in no slot of a point.
void StudyRunner::PlanBesides(const Planner& planner, std::size_t experiment,
                              std::vector<Job>& jobs) {
  const LedgerCandidate& best = Incumbent()->entry;
  const std::int64_t id = best.candidate.id;
  for (int replicate = 0; replicate < study_.backend.confirm_replicates; ++replicate) {
    PlannedRun planned = planner.PlanExperiment(experiment, best.parameters, replicate);
    jobs.push_back(
        {id,
         {.experiment = experiment, .replicate = replicate, .program = {}, .key = planned.key},
         &planner,
         true});
    if (const auto known = ledger_->FindRun(planned.key)) {
      runs_.insert_or_assign(known->id, *known);
      ledger_->AttachRun(known->id, id, BesidesReplicate(replicate));
    } else {
      queue_.push_back({id, std::move(planned), &planner, true});
    }
  }
}

void StudyRunner::RunQueue() {
  executor_ = std::make_unique<LocalExecutor>(study_.parallel());  // the last may be cancelled
  RunJobs([this] {
    while (Submit()) {
    }
  });
  SaveTimes(true);
}

void StudyRunner::PlanOthers() {
  for (std::size_t i = 0; i < study_.backend.confirm_with.size(); ++i) {
    others_.push_back({std::make_unique<Planner>(study_, *study_.backend.confirm_with[i]),
                       cost_.confirmations[i].experiments});
  }
  if (!study_.approximations.any()) return;
  const Backend* reference = study_.backend.backend.get();
  if (reference->name() != kReferenceBackend) {
    reference_ = MakeBackend(kReferenceBackend);
    reference_->Prepare({});
    reference = reference_.get();
    others_.push_back({std::make_unique<Planner>(study_, *reference), cost_.approximation});
  }
  others_.push_back(
      {std::make_unique<Planner>(study_, *reference, Planner::Law::exact), cost_.approximation});
}

// The best point on other backends: the same programs, hence the same particles. And what the
// study's approximations change.
void StudyRunner::ConfirmElsewhere() {
  const Point* best = Incumbent();
  if (best == nullptr || others_.empty()) return;
  for (const Other& other : others_) {
    for (const std::size_t experiment : study_.CalibratedExperiments()) {
      PlanBesides(*other.planner, experiment, confirmation_);
    }
  }
  if (options_.listener != nullptr) {
    options_.listener->OnConfirmation(best->entry, CurrentProgress());
  }
  RunQueue();
}

// The best point on what it was not fitted to.
void StudyRunner::EvaluateTransfer() {
  const Point* best = Incumbent();
  if (best == nullptr || options_.evaluate_also.empty()) return;
  for (const std::size_t experiment : options_.evaluate_also) {
    PlanBesides(planner_, experiment, transfer_);
  }
  if (options_.listener != nullptr) options_.listener->OnTransfer(best->entry, CurrentProgress());
  RunQueue();
}

void StudyRunner::Replay() {
  for (LedgerRun& run : ledger_->Runs()) runs_.emplace(run.id, std::move(run));
  std::map<std::int64_t, LedgerCandidate> stored;
  for (LedgerCandidate& entry : ledger_->Candidates()) {
    stored.emplace(entry.candidate.id, std::move(entry));
  }
  for (const LedgerEvent& event : ledger_->Events()) {
    if (event.kind == LedgerEvent::Kind::tell) {
      Point& point = points_.at(event.observation->id);
      optimizer_->Tell(std::span(&*event.observation, 1));
      AddReplicates(point, event.replicates);
      KeepTold(point, event.replicates, RunsOf(point, event.replicates));
      std::erase(awaiting_tell_, event.observation->id);
      Decide();
      continue;
    }
    const std::vector<Candidate> again = optimizer_->Ask(event.max_count);
    const bool same = again.size() == event.candidates.size() &&
                      std::equal(again.begin(), again.end(), event.candidates.begin(),
                                 [&](const Candidate& candidate, std::int64_t id) {
                                   const Candidate& known = stored.at(id).candidate;
                                   return candidate.id == id && candidate.point == known.point &&
                                          candidate.fidelity == known.fidelity;
                                 });
    if (!same) {
      throw InputError(
          "the optimizer no longer asks for the points that the ledger holds (another version of "
          "the program?); start anew with another --out",
          {.location = {directory_->ledger().string()}});
    }
    for (const std::int64_t id : event.candidates) Register(stored.at(id));
  }
  if (!points_.empty() && options_.listener != nullptr) options_.listener->OnResume(told_);
}

void StudyRunner::Register(const LedgerCandidate& candidate) {
  Point& point = points_[candidate.candidate.id];
  point.entry = candidate;
  asked_ += fidelities_.CostAt(candidate.candidate.fidelity);
  awaiting_tell_.push_back(candidate.candidate.id);
  AddReplicates(point, study_.backend.replicates);
}

// Plans the replicates up to `count`; those that the ledger holds are served from it.
void StudyRunner::AddReplicates(Point& point, int count) {
  const std::int64_t id = point.entry.candidate.id;
  const Planner& planner = fidelities_.PlannerAt(point.entry.candidate.fidelity);
  for (; point.replicates < count; ++point.replicates) {
    for (PlannedRun& planned : planner.Plan(point.entry.parameters, point.replicates)) {
      Point::Slot slot{.replicate = planned.replicate, .key = planned.key};
      if (const auto known = ledger_->FindRun(planned.key)) {
        slot.run = known->id;
        runs_.insert_or_assign(known->id, *known);
        ledger_->AttachRun(known->id, id, planned.replicate);
      } else {
        queue_.push_back({id, std::move(planned), &planner});
      }
      point.slots.push_back(std::move(slot));
    }
  }
}

bool StudyRunner::BudgetUsed() const {
  constexpr double kRounding = 1e-9;  // of a sum of costs
  return asked_ >= study_.budget.evaluations - kRounding;
}

bool StudyRunner::MayAsk() const {
  if (!stop_reason_.empty() || BudgetUsed()) return false;
  if (optimizer_->status().phase != Status::Phase::ready) return false;
  if (!study_.budget.deterministic) return true;
  const int runs_per_point =
      study_.backend.replicates * static_cast<int>(study_.CalibratedExperiments().size());
  const int window = (study_.parallel() + runs_per_point - 1) / runs_per_point;
  return static_cast<int>(awaiting_tell_.size()) < window;
}

bool StudyRunner::Ask() {
  const std::vector<Candidate> candidates = optimizer_->Ask(1);
  if (candidates.empty()) return false;
  std::vector<LedgerCandidate> entries;
  for (const Candidate& candidate : candidates) {
    LedgerCandidate entry{.candidate = candidate};
    for (const double value : study_.space.FromUnit(candidate.point)) {
      entry.parameters.push_back(value);
    }
    entries.push_back(std::move(entry));
  }
  worked_ = true;
  ledger_->AddAsk(1, entries);
  for (const LedgerCandidate& entry : entries) {
    Register(entry);
    const Point& point = points_.at(entry.candidate.id);
    const auto cached = std::count_if(point.slots.begin(), point.slots.end(),
                                      [](const Point::Slot& slot) { return slot.run.has_value(); });
    if (cached > 0) ledger_->SetCachedRuns(entry.candidate.id, static_cast<int>(cached));
  }
  return true;
}

// Keeps every slot of the executor busy.
void StudyRunner::AskAndSubmit() {
  if (stop_reason_.empty() && study_.budget.wall_time && Elapsed() > *study_.budget.wall_time) {
    stop_reason_ = fmt::format("wall time of {:g} s used", *study_.budget.wall_time);
    queue_.clear();  // what is in flight may end, and counts
  }
  if (study_.budget.deterministic) {
    ConverseInOrder();
    while (Submit()) {
    }
  } else {
    while (Submit() || (HasFreeSlot() && MayAsk() && Ask())) {
      TellWhatIsReady();  // the ledger may have held all runs of what was asked
    }
  }
  if (in_flight_.empty() && queue_.empty()) Decide();
  while (Submit()) {
  }
}

bool StudyRunner::HasFreeSlot() const {
  return static_cast<int>(in_flight_.size()) < executor_->capacity();
}

bool StudyRunner::Submit() {
  if (queue_.empty() || !HasFreeSlot()) return false;
  Job job = std::move(queue_.front());
  queue_.pop_front();
  // Two points with equal parameters share their runs.
  if (IsDone(job.run.key) || IsInFlight(job.run.key)) return true;
  const std::int64_t ticket = next_ticket_++;
  std::string name =
      fmt::format("{:04}-{}-{}", job.candidate, job.run.program.experiment, job.run.replicate);
  const std::string& backend = job.planner->backend().name();
  if (backend != planner_.backend().name()) name += "-" + backend;
  if (job.planner->law() == Planner::Law::exact) name += "-exact";
  RunContext context{.work_folder = directory_->work_folder(name),
                     .keep_files = study_.budget.keep_files};
  if (study_.budget.run_timeout) {
    context.time_limit = std::chrono::duration<double>(*study_.budget.run_timeout);
  }
  executor_->Submit(ticket,
                    [run = job.run, planner = job.planner, context](std::stop_token stop) mutable {
                      context.stop = std::move(stop);
                      return planner->Execute(run, context);
                    });
  in_flight_.emplace(ticket, std::move(job));
  return true;
}

void StudyRunner::Collect(const Executor::Finished& finished) {
  worked_ = true;
  const Job job = std::move(in_flight_.extract(finished.ticket).mapped());
  LedgerRun run = finished.run;
  outside_simulator_ += run.total_seconds - run.diagnostics.wall_seconds;
  if (run.outcome.reason == Reason::cancelled) return;  // not a result: planned again on resuming
  run.id = ledger_->AddRun(run, job.candidate,
                           job.besides ? BesidesReplicate(job.run.replicate) : job.run.replicate);
  runs_.insert_or_assign(run.id, run);
  for (auto& [id, point] : points_) {
    for (Point::Slot& slot : point.slots) {
      if (slot.key != run.key) continue;
      slot.run = run.id;
      ledger_->AttachRun(run.id, id, slot.replicate);
    }
  }
  if (options_.listener != nullptr) options_.listener->OnRun(run, CurrentProgress());
  if (!study_.budget.deterministic) TellWhatIsReady();  // else in order, when asking
  SaveTimes(false);
}

bool StudyRunner::IsReady(const Point& point) const {
  return std::all_of(point.slots.begin(), point.slots.end(),
                     [](const Point::Slot& slot) { return slot.run.has_value(); });
}

void StudyRunner::TellWhatIsReady() {
  for (std::size_t i = 0; i < awaiting_tell_.size() && !interrupted_ && !complete_;) {
    Point& point = points_.at(awaiting_tell_[i]);
    if (IsReady(point)) {
      awaiting_tell_.erase(awaiting_tell_.begin() + static_cast<std::ptrdiff_t>(i));
      Tell(point);
    } else {
      ++i;
    }
  }
}

// In deterministic mode the conversation with the optimizer must not depend on what happens to have
// finished: a fixed number of points is outstanding whenever the oldest of them is told.
void StudyRunner::ConverseInOrder() {
  while (!interrupted_ && !complete_) {
    while (MayAsk() && Ask()) {
    }
    if (awaiting_tell_.empty() || !IsReady(points_.at(awaiting_tell_.front()))) return;
    Point& point = points_.at(awaiting_tell_.front());
    awaiting_tell_.pop_front();
    Tell(point);
  }
}

// What is told of a point, now or by an earlier process.
void StudyRunner::KeepTold(Point& point, int replicates,
                           const std::vector<const LedgerRun*>& runs) {
  const bool first = point.told_replicates == 0;
  point.told = Reduce(objectives_, runs);
  point.told_replicates = replicates;
  incumbent_.reset();
  if (!first) return;
  ++told_;
  told_cost_ += fidelities_.CostAt(point.entry.candidate.fidelity);
  if (point.told.failed()) ++failed_;
  if (point.told.partial()) ++partial_;
}

void StudyRunner::Tell(Point& point) {
  const auto runs = RunsOf(point, point.replicates);
  KeepTold(point, point.replicates, runs);
  const auto failures = FailuresOf(objectives_, point.told, runs);
  std::vector<std::string> reasons;
  for (const ExperimentFailure& failure : failures) {
    reasons.push_back(failure.experiment + " " + failure.reason);
  }
  const Observation observation{
      .id = point.entry.candidate.id,
      .point = point.entry.candidate.point,
      .responses = point.told.means,
      .variances = VarianceOfMeans(point.told, Pooled(point.entry.candidate.fidelity)),
      .failed = point.told.failed(),
      .failure = JoinNames(reasons),
      .fidelity = point.entry.candidate.fidelity};
  ledger_->AddTell(observation, point.replicates);
  optimizer_->Tell(std::span(&observation, 1));
  if (options_.listener != nullptr) {
    options_.listener->OnEvaluation(point.entry, point.told, failures, CurrentProgress());
  }
  Decide();
}

// After each tell: is the best point good enough to be confirmed, or the study at its end? A
// function of what has been told and asked alone, so that replaying the ledger decides alike.
void StudyRunner::Decide() {
  if (!stop_reason_.empty()) return;
  Point* best = Incumbent();
  const bool promising = best != nullptr && WithinTolerance(study_, best->told);
  const bool confirmed =
      best != nullptr && best->told_replicates >= study_.backend.confirm_replicates;
  if (promising && confirmed) {
    stop_reason_ = "every tolerance reached";
    complete_ = true;
    queue_.clear();
    if (executor_) executor_->Cancel();
    return;
  }
  const Status status = optimizer_->status();
  const bool budget_used = BudgetUsed();
  const bool exhausted = budget_used || status.phase == Status::Phase::finished;
  const bool idle = awaiting_tell_.empty();
  if (best != nullptr && !confirmed && (promising || (exhausted && idle))) {
    if (best->replicates >= study_.backend.confirm_replicates) return;  // already on its way
    AddReplicates(*best, study_.backend.confirm_replicates);
    awaiting_tell_.push_back(best->entry.candidate.id);
    return;
  }
  if (!idle) return;
  if (budget_used) {
    stop_reason_ = fmt::format("budget of {} evaluations used", study_.budget.evaluations);
  } else if (status.phase != Status::Phase::ready) {
    stop_reason_ =
        "the optimizer has finished" + (status.message.empty() ? "" : ": " + status.message);
  }
}

bool StudyRunner::IsDone(const std::string& key) const {
  return std::any_of(runs_.begin(), runs_.end(),
                     [&](const auto& entry) { return entry.second.key == key; });
}

bool StudyRunner::IsInFlight(const std::string& key) const {
  return std::any_of(in_flight_.begin(), in_flight_.end(),
                     [&](const auto& entry) { return entry.second.run.key == key; });
}

StudyRunner::Point* StudyRunner::Incumbent() {
  if (incumbent_) return *incumbent_;
  std::vector<Point*> told;
  std::vector<Eigen::VectorXd> coordinates;
  std::vector<ReducedResponses> reduced;
  for (auto& [id, point] : points_) {
    if (point.told_replicates == 0 || point.entry.candidate.fidelity < 1) continue;
    told.push_back(&point);
    coordinates.push_back(point.entry.candidate.point);
    reduced.push_back(point.told);
  }
  const std::vector<double> misfits =
      RankingMisfits(study_.space, objectives_, coordinates, reduced);
  const auto lowest = std::min_element(misfits.begin(), misfits.end());
  incumbent_ = lowest == misfits.end() || std::isinf(*lowest)
                   ? nullptr
                   : told[static_cast<std::size_t>(lowest - misfits.begin())];
  return *incumbent_;
}

std::vector<const LedgerRun*> StudyRunner::RunsOf(const Point& point, int replicates) const {
  std::vector<const LedgerRun*> runs;
  for (const Point::Slot& slot : point.slots) {
    if (slot.run && slot.replicate < replicates) runs.push_back(&runs_.at(*slot.run));
  }
  return runs;
}

Eigen::VectorXd StudyRunner::Pooled(double fidelity) const {
  std::vector<ReducedResponses> told;
  for (const auto& [id, point] : points_) {
    if (point.told_replicates == 0 || point.entry.candidate.fidelity != fidelity) continue;
    told.push_back(point.told);
  }
  return PooledSeedVariance(told, static_cast<int>(objectives_.targets.size()));
}

double StudyRunner::Elapsed() const { return earlier_.wall + Seconds(Clock::now() - start_); }

Progress StudyRunner::CurrentProgress() {
  Progress progress{.done = told_,
                    .used = told_cost_,
                    .budget = study_.budget.evaluations,
                    .failed = failed_,
                    .partial = partial_,
                    .running = static_cast<int>(in_flight_.size()),
                    .confirmation_runs = static_cast<int>(confirmation_.size()),
                    .transfer_runs = static_cast<int>(transfer_.size()),
                    .elapsed_seconds = Elapsed()};
  const auto done = [this](const std::vector<Job>& jobs) {
    return static_cast<int>(std::count_if(jobs.begin(), jobs.end(),
                                          [&](const Job& job) { return IsDone(job.run.key); }));
  };
  progress.confirmation_done = done(confirmation_);
  progress.transfer_done = done(transfer_);
  if (const Point* best = Incumbent()) {
    progress.best = best->entry.candidate.id;
    progress.best_parameters = best->entry.parameters;
    progress.best_responses = best->told;
  }
  if (!runs_.empty()) progress.seconds_left = SecondsLeft();
  return progress;
}

// Wall clock of one run of each experiment on a backend, at the study's fidelity: the mean of those
// that have ended, else what was expected of it.
std::vector<double> StudyRunner::SecondsPerRun(
    const std::string& backend, const std::vector<Planner::ExperimentCost>& expected) const {
  std::vector<double> seconds(study_.experiments.size());
  for (const Planner::ExperimentCost& one : expected) seconds[one.experiment] = one.seconds;
  for (std::size_t i = 0; i < seconds.size(); ++i) {
    double sum = 0;
    int count = 0;
    for (const auto& [id, run] : runs_) {
      if (run.experiment != study_.experiments[i].name() || run.backend != backend ||
          run.fidelity != ToString(study_.FidelityOf(i))) {
        continue;
      }
      sum += run.total_seconds;
      ++count;
    }
    if (count > 0) seconds[i] = sum / count;
  }
  return seconds;
}

double StudyRunner::SecondsLeft() const {
  const std::vector<double> seconds = SecondsPerRun(planner_.backend().name(), cost_.experiments);
  const double points = std::max(0.0, study_.budget.evaluations - told_cost_);
  const int confirm = study_.backend.confirm_replicates - study_.backend.replicates;
  double left = 0;
  if (!ended_) {
    for (const std::size_t i : study_.CalibratedExperiments()) {
      left += seconds[i] * (points * study_.backend.replicates + confirm);
    }
    left /= study_.parallel();
    if (study_.budget.wall_time) {
      left = std::min(left, std::max(0.0, *study_.budget.wall_time - Elapsed()));
    }
  }
  double besides = 0;  // of what comes after the calibration
  for (const Other& other : others_) {
    const std::vector<double> each = SecondsPerRun(other.planner->backend().name(), other.expected);
    for (const Planner::ExperimentCost& one : other.expected) {
      if (!ended_) besides += each[one.experiment] * study_.backend.confirm_replicates;
    }
    for (const Job& job : confirmation_) {
      if (job.planner != other.planner.get() || IsDone(job.run.key)) continue;
      besides += each[job.run.experiment];
    }
  }
  if (transfer_.empty()) {
    for (const std::size_t i : options_.evaluate_also) {
      besides += seconds[i] * study_.backend.confirm_replicates;
    }
  }
  for (const Job& job : transfer_) {
    if (!IsDone(job.run.key)) besides += seconds[job.run.experiment];
  }
  return left + besides / study_.parallel();
}

void StudyRunner::SaveTimes(bool now) {
  if (!now && Clock::now() - saved_ < std::chrono::seconds(1)) return;
  saved_ = Clock::now();
  if (!worked_) return;  // looking at a finished study costs it nothing
  const double wall = Seconds(Clock::now() - start_);
  ledger_->UpdateSession(session_, {wall, wall - waiting_seconds_ + outside_simulator_});
}

}  // namespace powdercal
