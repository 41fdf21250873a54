%QUICK_RETURN_FIGURES Figures 6 to 11 of the assignment, and its animation, from the generated functions.
%
%   All numbers of a row belong to its own time: docs/the-document.md lists what differs in the assignment's script.
%
%       cargo run --release -- code quick-return --language matlab --out out/matlab
%       octave --persist --path out/matlab examples/matlab/quick_return_figures.m
%
%   In MATLAB: addpath out/matlab, then run examples/matlab/quick_return_figures.m.

p = quick_return_parameters();
motion = quick_return_motion(p);
t = motion.t;
phi = motion.q;
[x6, x6_dot, x6_ddot, v_slide, N3, N6] = deal(motion.outputs(:, 1), motion.outputs(:, 2), motion.outputs(:, 3), ...
    motion.outputs(:, 4), motion.outputs(:, 5), motion.outputs(:, 6));
fprintf('%d steps, two revolutions in %.15g s\n', numel(t) - 1, t(end));

figure(6);
plot(t, motion.qd);
title('Angular speeds of crank, rocker and rod');
ylabel('angular speed (rad/s)');
legend('crank', 'rocker', 'rod');

figure(7);
plot(t, x6);
title('Position of the ram');
ylabel('x6 (m)');

figure(8);
plot(t, x6_dot);
title('Velocity of the ram');
ylabel('velocity (m/s)');

figure(9);
plot(t, x6_ddot);
title('Acceleration of the ram');
ylabel('acceleration (m/s^2)');

figure(10);
plot(t, v_slide);
title('Sliding speed of the block along the rocker, outward');
ylabel('speed (m/s)');

figure(11);
plot(t, N3, t, N6);
title('Reaction forces');
ylabel('force (N)');
legend('N3, rocker on block, across the slot', 'N6, guide on ram, upward');

for number = 6:11
    figure(number);
    xlabel('t (s)');
    grid on;
end

% The animation: 25 pictures a second.
A = @(phi) [p.O2A * cos(phi(1)), p.O4O2 + p.O2A * sin(phi(1))];
B = @(phi) p.O4B * [cos(phi(2)), sin(phi(2))];
C = @(phi) B(phi) + p.BC * [cos(phi(3)), sin(phi(3))];
figure(12);
hold on;
plot([-1.5, 0.25] * p.O4B, [p.yC, p.yC], 'k:', [0, 0], [0, p.O4O2], 'k^');
rocker = plot(0, 0, 'b-', 'LineWidth', 2);
crank = plot(0, 0, 'r-', 'LineWidth', 2);
rod = plot(0, 0, 'g-', 'LineWidth', 2);
blocks = plot(0, 0, 'ks', 'MarkerSize', 10);
axis equal;
axis([-1.5 * p.O4B, 0.8 * p.O4B, -0.1, 1.1 * p.yC]);
xlabel('x (m)');
ylabel('y (m)');
for time = 0:0.04:t(end)
    now_phi = interp1(t, phi, time);
    [a, b, c] = deal(A(now_phi), B(now_phi), C(now_phi));
    set(rocker, 'XData', [0, b(1)], 'YData', [0, b(2)]);
    set(crank, 'XData', [0, a(1)], 'YData', [p.O4O2, a(2)]);
    set(rod, 'XData', [b(1), c(1)], 'YData', [b(2), c(2)]);
    set(blocks, 'XData', [a(1), c(1)], 'YData', [a(2), c(2)]);
    title(sprintf('t = %.2f s', time));
    drawnow;
    pause(0.04);
end
